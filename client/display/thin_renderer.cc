#include "client/display/thin_renderer.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/display/count_pool.h"
#include "client/display/draw_list.h"
#include "client/display/gpu_mesh.h"
#include "client/display/picture_tile.h"
#include "client/display/surface_glsl.h"
#include "client/display/word_pool.h"
#include "render/gl/draw.h"
#include "render/gl/framebuffer.h"
#include "render/gl/program.h"
#include "render/scene/field_error.h"
#include "render/scene/unoccluded_light.h"

namespace penumbra {
namespace {

// Side of the square that is drawn at once, in shading samples: 84 MB at 4 edge samples of 20
// bytes.
constexpr int kTileSide = 1024;
constexpr int kEdgeSamples = 4;
constexpr int kMaxPictureSide = 16'384;
constexpr int kMaxSamplesPerSide = 8;

absl::Status CheckRange(const char* field, int found, int max) {
  if (found >= 1 && found <= max) return absl::OkStatus();
  return FieldError(absl::StatusCode::kInvalidArgument, "RANGE", field,
                    absl::StrCat("found ", found, ", need 1 to ", max));
}

absl::Status CheckOptions(const RenderOptions& options) {
  for (const auto& status :
       {CheckRange("width", options.width, kMaxPictureSide),
        CheckRange("height", options.height, kMaxPictureSide),
        CheckRange("samples_per_side", options.samples_per_side, kMaxSamplesPerSide)}) {
    if (!status.ok()) return status;
  }
  if (!IsFinite(options.ambient)) {
    return FieldError(absl::StatusCode::kInvalidArgument, "NON_FINITE", "ambient",
                      "need finite numbers");
  }
  return absl::OkStatus();
}

DMat4 Matrix(const Affine& m) {
  return DMat4(DVec4(m[0], 0), DVec4(m[1], 0), DVec4(m[2], 0), DVec4(m[3], 1));
}

// Takes normals along: the cofactors, which unlike the inverse exist for every map. Scaled, because
// only directions matter and products of large scales would overflow.
Mat4 NormalMatrix(const Affine& m) {
  const DVec3 x(m[0]), y(m[1]), z(m[2]);
  DVec3 columns[3] = {glm::cross(y, z), glm::cross(z, x), glm::cross(x, y)};
  double largest = 0;
  for (const DVec3& c : columns) largest = std::max(largest, glm::length(c));
  const double scale = largest > 0 ? 1 / largest : 0;
  return Mat4(Vec4(Vec3(scale * columns[0]), 0), Vec4(Vec3(scale * columns[1]), 0),
              Vec4(Vec3(scale * columns[2]), 0), Vec4(0, 0, 0, 1));
}

template <typename T>
absl::StatusOr<gl::Buffer> Upload(gl::Context& context, const std::vector<T>& values) {
  return gl::Buffer::Create(context, std::as_bytes(std::span(values)));
}

}  // namespace

class ThinRenderer::Impl {
 public:
  explicit Impl(gl::ProgramSource surface) : surface_source_(std::move(surface)) {}

  absl::Status Bind(gl::Context& context);
  absl::StatusOr<Picture> Render(gl::Context& context, const Scene& scene,
                                 std::span<const std::shared_ptr<const Artifact>> artifacts,
                                 const Camera& camera, const RenderOptions& options);
  Uploads uploads() const {
    return {meshes_.upload_count(), masks_.upload_count(),
            counts_.upload_count() + words_.upload_count()};
  }

 private:
  struct Frame {
    gl::Buffer lights, receivers, candidates;
  };

  absl::StatusOr<Frame> Prepare(gl::Context& context, const DrawList& list, const Camera& camera);
  void SetFrame(gl::Context& context, const DrawList& list, const Camera& camera,
                const RenderOptions& options);
  absl::Status DrawItemOn(gl::Context& context, const DrawItem& item, const DMat4& clip_from_world);
  absl::Status RenderTile(gl::Context& context, const DrawList& list, const DMat4& tile_from_world,
                          const PictureTile& tile, int samples_per_side, Picture& picture);
  absl::Status EnsureTarget(gl::Context& context, int side);

  const gl::ProgramSource surface_source_;
  uint64_t context_serial_ = 0;
  std::optional<gl::Program> surface_, glow_;
  std::optional<gl::Framebuffer> target_;
  UploadCache<GpuMesh> meshes_;
  UploadCache<gl::Texture> masks_;
  CountPool counts_;
  WordPool words_;
};

// Starts anew when the context is another one than before.
absl::Status ThinRenderer::Impl::Bind(gl::Context& context) {
  if (absl::Status status = context.Check("the thin renderer"); !status.ok()) return status;
  if (context_serial_ == context.serial()) return absl::OkStatus();
  meshes_.Clear();
  masks_.Clear();
  counts_.Clear();
  words_.Clear();
  target_.reset();
  auto surface = gl::Program::Create(context, surface_source_);
  if (!surface.ok()) return surface.status();
  auto glow = gl::Program::Create(context, GlowProgram());
  if (!glow.ok()) return glow.status();
  surface_ = *std::move(surface);
  glow_ = *std::move(glow);
  context_serial_ = context.serial();
  return absl::OkStatus();
}

absl::Status ThinRenderer::Impl::EnsureTarget(gl::Context& context, int side) {
  const int samples = std::min(kEdgeSamples, context.info().max_samples);
  if (target_ && target_->options().width == side) return absl::OkStatus();
  target_.reset();
  auto target =
      gl::Framebuffer::Create(context, {.width = side, .height = side, .samples = samples});
  if (!target.ok()) return target.status();
  target_ = *std::move(target);
  return absl::OkStatus();
}

absl::StatusOr<ThinRenderer::Impl::Frame> ThinRenderer::Impl::Prepare(gl::Context& context,
                                                                      const DrawList& list,
                                                                      const Camera& camera) {
  if (absl::Status status = counts_.Update(context, list); !status.ok()) return status;
  if (absl::Status status = words_.Update(context, list, camera); !status.ok()) return status;
  auto lights = Upload(context, list.lights);
  auto receivers = Upload(context, list.receivers);
  auto candidates = Upload(context, list.candidates);
  for (const auto* buffer : {&lights, &receivers, &candidates}) {
    if (!buffer->ok()) return buffer->status();
  }
  lights->BindStorage(context, kLightsBinding);
  receivers->BindStorage(context, kReceiversBinding);
  candidates->BindStorage(context, kCandidatesBinding);
  counts_.buffer().BindStorage(context, kCountsBinding);
  words_.Bind(context);
  return Frame{*std::move(lights), *std::move(receivers), *std::move(candidates)};
}

void ThinRenderer::Impl::SetFrame(gl::Context& context, const DrawList& list, const Camera& camera,
                                  const RenderOptions& options) {
  for (gl::Program* program : {&*surface_, &*glow_}) {
    program->Set(context, "eye", camera.eye);
    program->Set(context, "clip_radiance", options.clip_radiance);
  }
  surface_->Set(context, "ambient", options.ambient);
  surface_->Set(context, "culls_back_faces", options.culls_back_faces ? 1 : 0);
  surface_->Set(context, "light_count", static_cast<int>(list.lights.size()));
}

absl::Status ThinRenderer::Impl::DrawItemOn(gl::Context& context, const DrawItem& item,
                                            const DMat4& clip_from_world) {
  auto mesh = meshes_.Find(*item.mesh, [&](const Mesh& m) { return GpuMesh::Create(context, m); });
  if (!mesh.ok()) return mesh.status();
  gl::Program& program = item.glows ? *glow_ : *surface_;
  const DMat4 world_from_mesh = Matrix(item.world_from_mesh);
  program.Set(context, "clip_from_mesh", Mat4(clip_from_world * world_from_mesh));
  program.Set(context, "world_from_mesh", Mat4(world_from_mesh));
  program.Set(context, "world_from_mesh_normal", NormalMatrix(item.world_from_mesh));
  program.Set(context, "depth_scale", item.depth_scale);
  program.Set(context, "has_face_normals", (*mesh)->has_face_normals ? 1 : 0);
  if (item.glows) {
    program.Set(context, "radiance", item.color);
    program.Set(context, "two_sided", item.two_sided ? 1 : 0);
  } else {
    program.Set(context, "color", item.color);
    program.Set(context, "has_vertex_normals", (*mesh)->has_normals ? 1 : 0);
    program.Set(context, "alpha_cutoff", item.alpha_cutoff);
    program.Set(context, "has_mask", item.alpha_mask != nullptr ? 1 : 0);
    program.Set(context, "receives", item.receives ? 1 : 0);
    program.Set(context, "first_candidate", item.first_candidate);
    program.Set(context, "end_candidate", item.end_candidate);
  }
  if (item.alpha_mask != nullptr) {
    auto mask = masks_.Find(*item.alpha_mask,
                            [&](const AlphaMask& m) { return CreateMaskTexture(context, m); });
    if (!mask.ok()) return mask.status();
    (*mask)->Bind(context, kMaskUnit);
  }
  (*mesh)->face_normals.BindStorage(context, kFaceNormalsBinding);
  gl::Draw(context, {.program = program,
                     .vertices = (*mesh)->vertices,
                     .target = *target_,
                     .count = (*mesh)->index_count});
  return absl::OkStatus();
}

absl::Status ThinRenderer::Impl::RenderTile(gl::Context& context, const DrawList& list,
                                            const DMat4& tile_from_world, const PictureTile& tile,
                                            int samples_per_side, Picture& picture) {
  target_->Clear(context, Vec4(0));
  for (const DrawItem& item : list.items) {
    if (IsOutside(tile_from_world, item.bounds)) continue;
    if (absl::Status status = DrawItemOn(context, item, tile_from_world); !status.ok()) {
      return status;
    }
  }
  const auto samples = target_->ReadPixels(context);
  if (!samples.ok()) return samples.status();
  ResolveTile(*samples, samples_per_side, tile, picture);
  return absl::OkStatus();
}

absl::StatusOr<Picture> ThinRenderer::Impl::Render(
    gl::Context& context, const Scene& scene,
    std::span<const std::shared_ptr<const Artifact>> artifacts, const Camera& camera,
    const RenderOptions& options) {
  const DrawList list = BuildDrawList(scene, artifacts, options.draws_lights);
  const auto frame = Prepare(context, list, camera);
  if (!frame.ok()) return frame.status();
  SetFrame(context, list, camera, options);
  const int n = options.samples_per_side;
  const int side = std::min(kTileSide / n, std::max(options.width, options.height));  // pixels
  if (absl::Status status = EnsureTarget(context, side * n); !status.ok()) return status;
  const double aspect = static_cast<double>(options.width) / options.height;
  const DMat4 clip_from_world = ClipFromWorld(camera, aspect);

  Picture picture = {.width = options.width, .height = options.height, .pixels = {}};
  picture.pixels.resize(static_cast<size_t>(options.width) * options.height);
  for (int y = 0; y < options.height; y += side) {
    for (int x = 0; x < options.width; x += side) {
      const PictureTile tile = {.x = x,
                                .y = y,
                                .width = std::min(side, options.width - x),
                                .height = std::min(side, options.height - y),
                                .side = side};
      const DMat4 tile_from_world =
          TileFromClip(tile, options.width, options.height) * clip_from_world;
      const absl::Status status = RenderTile(context, list, tile_from_world, tile, n, picture);
      if (!status.ok()) return status;
    }
  }
  meshes_.EndFrame();
  masks_.EndFrame();
  return picture;
}

ThinRenderer::ThinRenderer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ThinRenderer::~ThinRenderer() = default;

absl::StatusOr<std::unique_ptr<ThinRenderer>> ThinRenderer::Create(gl::Context& context,
                                                                   gl::ProgramSource surface) {
  auto impl = std::make_unique<Impl>(std::move(surface));
  if (absl::Status status = impl->Bind(context); !status.ok()) return status;
  return std::unique_ptr<ThinRenderer>(new ThinRenderer(std::move(impl)));
}

absl::StatusOr<Picture> ThinRenderer::Render(
    gl::Context& context, const Scene& scene,
    std::span<const std::shared_ptr<const Artifact>> artifacts, const Camera& camera,
    const RenderOptions& options) {
  if (absl::Status status = CheckOptions(options); !status.ok()) return status;
  if (absl::Status status = CheckCamera(camera); !status.ok()) return status;
  if (absl::Status status = impl_->Bind(context); !status.ok()) return status;
  return impl_->Render(context, scene, artifacts, camera, options);
}

ThinRenderer::Uploads ThinRenderer::uploads() const { return impl_->uploads(); }

Vec3 SuggestAmbient(const Scene& scene) {
  constexpr float kShare =
      0.06f;  // dark enough to leave shadows their shape, bright enough to see in
  const Aabb bounds = scene.Bounds();
  if (scene.lights().empty()) return Vec3(1);
  const Vec3 center = bounds.empty() ? Vec3(0) : bounds.center();
  Vec3 sum(0);
  for (const auto& [id, light] : scene.lights()) {
    Vec3 brightest(0);
    for (const Vec3 n : {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 1, 0), Vec3(0, -1, 0),
                         Vec3(0, 0, 1), Vec3(0, 0, -1)}) {
      brightest = glm::max(brightest, UnoccludedRadiance(*light, center, n));
    }
    sum += brightest;
  }
  return kShare * sum;
}

}  // namespace penumbra
