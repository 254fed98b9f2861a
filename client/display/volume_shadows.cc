#include "client/display/volume_shadows.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <set>
#include <span>
#include <utility>
#include <variant>

#include "client/display/word_pool.h"
#include "render/artifact/light_extent.h"

namespace penumbra {
namespace {

constexpr char kVertexGlsl[] = R"glsl(
layout(location = 0) in vec4 place;  // homogeneous
uniform mat4 clip_from_place;
uniform bool is_cap;

void main() {
  gl_Position = clip_from_place * place;
  if (is_cap) gl_Position.z = 0.0;  // on the near plane, which would clip it for rounding
}
)glsl";

constexpr char kFragmentGlsl[] = R"glsl(
layout(location = 0) out vec4 pixel;
void main() { pixel = vec4(0.0); }
)glsl";

// How far all passes of several are moved away from the light besides, in pixels' widths, so that
// what is moved aside does not come out before the surface that light falls on.
constexpr double kBack = 0.75;

const ShadowVolumeMesh& MeshOf(const Artifact& artifact) {
  return std::get<ShadowVolumeMesh>(artifact.payload);
}

// One volume whose boundary any triangle crosses can do with a bit; several may lie in each other.
bool Counts(const ShadowVolumeMesh& mesh) {
  return mesh.volumes.size() != 1 || mesh.volumes.front()->kind == VolumeKind::kObject;
}

// All volumes' vertices after each other, and triangles as often as they weigh, turned about where
// that is less than 0.
void Append(const ShadowVolume& volume, std::vector<Vec4>& vertices,
            std::vector<uint32_t>& indices) {
  const auto first = static_cast<uint32_t>(vertices.size());
  vertices.insert(vertices.end(), volume.vertices.begin(), volume.vertices.end());
  for (size_t t = 0; t < volume.triangle_count(); ++t) {
    const int weight = volume.weights.empty() ? 1 : volume.weights[t];
    const uint32_t a = first + volume.indices[3 * t], b = first + volume.indices[3 * t + 1],
                   c = first + volume.indices[3 * t + 2];
    for (int i = 0; i < std::abs(weight); ++i) {
      indices.insert(indices.end(), {a, weight > 0 ? b : c, weight > 0 ? c : b});
    }
  }
}

// Lights of which there is something that shadow volumes give way to.
std::set<uint32_t> LightsWithBetter(const DrawList& list, const Camera& camera) {
  std::set<uint32_t> lights;
  for (const Candidate& candidate : list.candidates) lights.insert(candidate.light);
  for (const auto& [light, artifact] : WordPool::Choose(list, camera)) lights.insert(light);
  return lights;
}

// The view of the first map, from which a sample's width is known.
const LightView* FirstView(const ShadowVolumeMesh& mesh) {
  for (const auto& volume : mesh.volumes) {
    if (!volume->faces.empty()) return &volume->faces.front().map.view;
  }
  return nullptr;
}

// A turn by `angle` about an axis of length 1 through a point, and away from there by a factor.
DMat4 TurnAbout(DVec3 point, DVec3 axis, double angle, double factor) {
  const auto turned = [&](DVec3 v) {
    return factor * (std::cos(angle) * v + (1 - std::cos(angle)) * glm::dot(axis, v) * axis +
                     std::sin(angle) * glm::cross(axis, v));
  };
  return DMat4(DVec4(turned(DVec3(1, 0, 0)), 0), DVec4(turned(DVec3(0, 1, 0)), 0),
               DVec4(turned(DVec3(0, 0, 1)), 0), DVec4(point - turned(point), 1));
}

DMat4 MoveBy(DVec3 way) {
  DMat4 result(1.0);
  result[3] = DVec4(way, 1);
  return result;
}

// About the golden section of `passes`, or more, with no factor in common: its multiples are all
// over [0, passes).
int Stride(int passes, double part) {
  int stride = std::max(1, static_cast<int>(std::lround(part * passes)));
  while (std::gcd(stride, passes) != 1) ++stride;
  return stride;
}

}  // namespace

DMat4 VolumeTurn(const ShadowVolumeMesh& mesh, int pass, int passes) {
  const LightView* const view = FirstView(mesh);
  if (passes <= 1 || view == nullptr) return DMat4(1.0);
  const auto place = [&](int stride) {
    return static_cast<double>(int64_t{pass} * stride % passes) / passes + 0.5 / passes - 0.5;
  };
  const DVec3 rook(place(1), place(Stride(passes, 0.618)), place(Stride(passes, 0.382)));
  const Basis& axes = view->frame.axes;
  const DVec2 pixel = 1.0 / view->pixels_per_slope();
  const double back = kBack * std::max(pixel.x, pixel.y);
  const DVec4 middle = PlaceOfMiddle(mesh.light);
  if (middle.w == 0) {
    return MoveBy(rook.x * pixel.x * axes.s + rook.y * pixel.y * axes.t - back * DVec3(middle));
  }
  // A turn about t moves what is ahead along s. One about n as well, since light may shine all
  // around, and then s is ahead too.
  const DVec3 turn =
      rook.x * pixel.x * axes.t + rook.y * pixel.y * axes.s + rook.z * pixel.x * axes.n;
  const double angle = glm::length(turn);
  const DVec3 axis = angle > 0 ? turn / angle : axes.n;
  return TurnAbout(DVec3(middle), axis, angle, 1 + back);
}

void VolumeShadows::Clear() {
  program_.reset();
  uploaded_.clear();
  of_light_.clear();
  lights_.clear();
}

absl::StatusOr<VolumeShadows::Volumes> VolumeShadows::Upload(
    gl::Context& context, std::shared_ptr<const Artifact> artifact) {
  const ShadowVolumeMesh& mesh = MeshOf(*artifact);
  Volumes volumes{.artifact = std::move(artifact), .counts = Counts(mesh)};
  std::vector<Vec4> vertices;
  std::vector<uint32_t> indices;
  for (const auto& volume : mesh.volumes) {
    Append(*volume, vertices, indices);
    volumes.cappers.emplace_back(*volume, mesh.bias_px, mesh.light);
  }
  volumes.index_count = static_cast<int>(indices.size());
  if (indices.empty()) return volumes;
  auto vertex_buffer = gl::Buffer::Create(context, std::as_bytes(std::span(vertices)));
  if (!vertex_buffer.ok()) return vertex_buffer.status();
  auto index_buffer = gl::Buffer::Create(context, std::as_bytes(std::span(indices)));
  if (!index_buffer.ok()) return index_buffer.status();
  auto array = gl::VertexArray::Create(context);
  if (!array.ok()) return array.status();
  volumes.vertex_buffer = *std::move(vertex_buffer);
  volumes.index_buffer = *std::move(index_buffer);
  volumes.vertices = *std::move(array);
  volumes.vertices.SetFloats(context, 0, volumes.vertex_buffer, 4);
  volumes.vertices.SetIndices(context, volumes.index_buffer);
  return volumes;
}

absl::Status VolumeShadows::Update(gl::Context& context, const DrawList& list,
                                   const Camera& camera) {
  const std::set<uint32_t> with_better = LightsWithBetter(list, camera);
  std::map<uint32_t, std::shared_ptr<const Artifact>> last;
  for (const auto& [light, artifact] : list.of_any_surface) {
    const bool is_mesh = std::holds_alternative<ShadowVolumeMesh>(artifact->payload);
    if (is_mesh && !with_better.contains(light)) last[light] = artifact;
  }
  std::map<const Artifact*, Volumes> now;
  lights_.clear();
  of_light_.clear();
  for (const auto& [light, artifact] : last) {
    lights_.push_back(light);
    of_light_[light] = artifact.get();
    if (auto before = uploaded_.extract(artifact.get()); !before.empty()) {
      now.insert(std::move(before));
      continue;
    }
    auto made = Upload(context, artifact);
    if (!made.ok()) return made.status();
    ++upload_count_;
    now.emplace(artifact.get(), *std::move(made));
  }
  uploaded_ = std::move(now);
  order_.clear();
  for (uint32_t light = 0; light < list.lights.size(); ++light) {
    if (!last.contains(light)) order_.push_back(light);
  }
  order_.insert(order_.end(), lights_.begin(), lights_.end());
  if (lights_.empty() || program_) return absl::OkStatus();
  auto program = gl::Program::Create(context, {.vertex = kVertexGlsl, .fragment = kFragmentGlsl});
  if (!program.ok()) return program.status();
  program_ = *std::move(program);
  return absl::OkStatus();
}

absl::StatusOr<VolumeShadows::Caps> VolumeShadows::CapsFor(gl::Context& context,
                                                           const Volumes& volumes,
                                                           const DMat4& clip_from_world,
                                                           double near) {
  Caps caps{.clip_from_world = clip_from_world};
  std::vector<Vec4> corners;
  for (const VolumeCapper& capper : volumes.cappers) {
    const VolumeCaps found = capper.CapsFor(clip_from_world, near);
    if (found.inverts) ++caps.first_value;
    corners.insert(corners.end(), found.corners.begin(), found.corners.end());
  }
  caps.corner_count = static_cast<int>(corners.size());
  if (corners.empty()) return caps;
  auto buffer = gl::Buffer::Create(context, std::as_bytes(std::span(corners)));
  if (!buffer.ok()) return buffer.status();
  auto array = gl::VertexArray::Create(context);
  if (!array.ok()) return array.status();
  caps.buffer = *std::move(buffer);
  caps.corners = *std::move(array);
  caps.corners.SetFloats(context, 0, caps.buffer, 4);
  return caps;
}

absl::Status VolumeShadows::Aim(gl::Context& context, const DMat4& clip_from_world, int passes) {
  const double near = clip_from_world[3][2];  // depth being reversed, z is that everywhere
  for (auto& [artifact, volumes] : uploaded_) {
    volumes.caps.clear();
    for (int pass = 0; pass < passes; ++pass) {
      const DMat4 turned = clip_from_world * VolumeTurn(MeshOf(*artifact), pass, passes);
      auto caps = CapsFor(context, volumes, turned, near);
      if (!caps.ok()) return caps.status();
      volumes.caps.push_back(*std::move(caps));
    }
  }
  return absl::OkStatus();
}

void VolumeShadows::Mark(gl::Context& context, gl::Framebuffer& target, const DMat4& tile_from_clip,
                         uint32_t light, int pass) {
  const Volumes& volumes = uploaded_.at(of_light_.at(light));
  const Caps& caps = volumes.caps.at(static_cast<size_t>(pass));
  target.ClearStencil(context, caps.first_value);
  program_->Set(context, "clip_from_place", Mat4(tile_from_clip * caps.clip_from_world));
  program_->Set(context, "is_cap", 0);
  gl::Draw(context, {.program = *program_,
                     .vertices = volumes.vertices,
                     .target = target,
                     .count = volumes.index_count,
                     .depth_test = gl::DepthTest::kNearer,
                     .writes_depth = false,
                     .writes_color = false,
                     .stencil = volumes.counts ? gl::Stencil::kCount : gl::Stencil::kInvert});
  program_->Set(context, "clip_from_place", Mat4(tile_from_clip));
  program_->Set(context, "is_cap", 1);
  gl::Draw(context, {.program = *program_,
                     .vertices = caps.corners,
                     .target = target,
                     .count = caps.corner_count,
                     .depth_test = gl::DepthTest::kNone,
                     .writes_depth = false,
                     .writes_color = false,
                     .stencil = volumes.counts ? gl::Stencil::kIncrement : gl::Stencil::kInvert});
}

}  // namespace penumbra
