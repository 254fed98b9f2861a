#include "render/technique/soft_texture/gl/shadow_renderer.h"

#include <algorithm>
#include <deque>
#include <utility>

#include "render/technique/soft_texture/gl/occluder_glsl.h"
#include "render/technique/soft_texture/gl/resolve_glsl.h"
#include "render/technique/soft_texture/gl/sample_term.h"

namespace penumbra::texture_gl {
namespace {

// A triangle that is drawn is a unit of work. On a software device as long takes a shadow in this
// many texels, and a visible sample's term in as many.
constexpr double kTexelsPerUnit = 8;

// Pages that are drawn before the first of them is waited for: enough to keep the device busy, and
// a bound on what waits to be read.
constexpr size_t kPagesInFlight = 4;

// Where GL was asked for.
constexpr char kField[] = "soft_texture.method";

// Targets of so many sizes are kept.
constexpr size_t kKeptTargets = 8;

template <typename T>
void Append(std::vector<std::byte>& bytes, std::span<const T> values) {
  const auto more = std::as_bytes(values);
  bytes.insert(bytes.end(), more.begin(), more.end());
}

// A uniform block: `header`, then `values`, of which the shader has room for kSamplesPerPass.
template <typename Header, typename T>
absl::StatusOr<gl::Buffer> Block(gl::Context& context, const Header& header,
                                 std::span<const T> values) {
  std::vector<std::byte> bytes;
  bytes.reserve(sizeof(Header) + kSamplesPerPass * sizeof(T));
  Append(bytes, std::span<const Header>(&header, 1));
  Append(bytes, values);
  bytes.resize(sizeof(Header) + kSamplesPerPass * sizeof(T));
  return gl::Buffer::Create(context, bytes);
}

gl::PixelArea AreaOf(const Tile& tile, const ReceiverPatch& receiver) {
  return {static_cast<int>(tile.x), static_cast<int>(tile.y), static_cast<int>(receiver.width),
          static_cast<int>(tile.rows)};
}

glm::ivec2 SlotOf(const Tile& tile) { return {tile.x, tile.y}; }
glm::ivec2 RowsOf(const Tile& tile) { return {tile.first_row, tile.rows}; }

}  // namespace

absl::StatusOr<ShadowRenderer*> ShadowRenderer::Of(gl::Context& context) {
  static constexpr char kOwner = 0;
  std::shared_ptr<void>& kept = context.Kept(&kOwner);
  if (!kept) {
    std::shared_ptr<ShadowRenderer> renderer(new ShadowRenderer(MeshStore::Of(context)));
    if (absl::Status status = renderer->CreatePrograms(context); !status.ok()) return status;
    kept = std::move(renderer);
  }
  return static_cast<ShadowRenderer*>(kept.get());
}

absl::Status ShadowRenderer::CreatePrograms(gl::Context& context) {
  auto vertices = gl::VertexArray::Create(context);
  if (!vertices.ok()) return vertices.status();
  no_attributes_ = *std::move(vertices);
  const std::pair<gl::Program*, gl::ProgramSource> programs[] = {{&opaque_, OccluderProgram(false)},
                                                                 {&masked_, OccluderProgram(true)},
                                                                 {&count_, ResolveProgram(false)},
                                                                 {&shade_, ResolveProgram(true)}};
  for (const auto& [program, source] : programs) {
    auto made = gl::Program::Create(context, source);
    if (!made.ok()) return made.status();
    *program = *std::move(made);
  }
  return absl::OkStatus();
}

absl::StatusOr<ShadowRenderer::Targets*> ShadowRenderer::TargetsFor(gl::Context& context,
                                                                    const Page& page, bool shades) {
  const std::tuple key(page.width, page.height, shades);
  if (const auto found = targets_.find(key); found != targets_.end()) return &found->second;
  if (targets_.size() >= kKeptTargets) targets_.clear();
  gl::FramebufferOptions options{.width = static_cast<int>(page.width),
                                 .height = static_cast<int>(page.height),
                                 .color = gl::Format::kRg32Ui,
                                 .has_depth = false};
  auto shadows = gl::Framebuffer::Create(context, options);
  if (!shadows.ok()) return shadows.status();
  options.color = shades ? gl::Format::kRgba32F : gl::Format::kR32F;
  auto sums = gl::Framebuffer::Create(context, options);
  if (!sums.ok()) return sums.status();
  return &targets_.emplace(key, Targets{*std::move(shadows), *std::move(sums)}).first->second;
}

absl::StatusOr<gl::Program*> ShadowRenderer::BindCaster(gl::Context& context,
                                                        const Caster& caster) {
  const Instance& instance = *caster.instance;
  gl::Program& program = instance.alpha_mask ? masked_ : opaque_;
  auto mesh = meshes_->Mesh(context, *instance.mesh, kField);
  if (!mesh.ok()) return mesh.status();
  (*mesh)->Bind(context);
  if (instance.alpha_mask) {
    auto mask = meshes_->Mask(context, *instance.alpha_mask, *instance.mesh, kField);
    if (!mask.ok()) return mask.status();
    (*mask)->Bind(context, kMaskUnit);
    program.Set(context, "least_alpha", LeastAlpha(instance.alpha_cutoff));
  }
  const char* const kColumns[] = {"column0", "column1", "column2", "column3"};
  for (int c = 0; c < 4; ++c) program.Set(context, kColumns[c], instance.world_from_mesh[c]);
  program.Set(context, "heights", Vec2(caster.lowest, caster.highest));
  program.Set(context, "facing", caster.facing);
  return &program;
}

absl::Status ShadowRenderer::DrawCaster(gl::Context& context, const Caster& caster,
                                        gl::Framebuffer& shadows, const gl::PixelArea& area,
                                        int samples, double texels, const std::stop_token& stop) {
  const auto program = BindCaster(context, caster);
  if (!program.ok()) return program.status();
  // Units of a sample, if each of its texels is drawn to once.
  const size_t triangles = caster.instance->mesh->triangle_count();
  const double sample_units = static_cast<double>(triangles) + texels / kTexelsPerUnit;
  const auto samples_at_a_time =
      static_cast<int>(std::clamp(pace_.most() / sample_units, 1.0, static_cast<double>(samples)));
  const auto all = static_cast<double>(triangles);
  const auto triangles_at_a_time =
      static_cast<size_t>(std::clamp(pace_.most() / sample_units * all, 1.0, all));
  for (int first = 0; first < samples; first += samples_at_a_time) {
    (*program)->Set(context, "first_sample", first);
    const int drawn_samples = std::min(samples_at_a_time, samples - first);
    for (size_t t = 0; t < triangles; t += triangles_at_a_time) {
      const size_t drawn = std::min(triangles_at_a_time, triangles - t);
      gl::Draw(context, {.program = **program,
                         .vertices = no_attributes_,
                         .target = shadows,
                         .count = static_cast<int>(3 * drawn),
                         .depth_test = gl::DepthTest::kNone,
                         .writes_depth = false,
                         .combine = gl::Combine::kOr,
                         .first = static_cast<int>(3 * t),
                         .instances = drawn_samples,
                         .area = area});
      const double units = drawn_samples * sample_units * static_cast<double>(drawn) / all;
      absl::Status status = pace_.Did(context, units, stop);
      if (!status.ok()) return status;
    }
  }
  return absl::OkStatus();
}

absl::Status ShadowRenderer::DrawTile(gl::Context& context, const Tile& tile,
                                      const ShadowWork& work, size_t pass, gl::Framebuffer& shadows,
                                      const std::stop_token& stop) {
  const ShadowRequest& request = *work.request;
  const auto maps = OfPass(work.maps, pass);
  if (maps.empty()) return absl::OkStatus();
  const GpuPlane plane{.front = DVec4(work.front, request.surface_offset)};
  auto block = Block(context, plane, maps);
  if (!block.ok()) return block.status();
  block->BindUniforms(context, kMapsBinding);
  const ReceiverPatch& receiver = request.receiver;
  for (gl::Program* program : {&opaque_, &masked_}) {
    program->Set(context, "origin", receiver.patch.origin);
    program->Set(context, "size", glm::ivec2(receiver.width, receiver.height));
    program->Set(context, "rows", RowsOf(tile));
    program->Set(context, "slot", SlotOf(tile));
  }
  for (const Caster& caster : work.casters) {
    if (stop.stop_requested()) return absl::CancelledError("stop requested");
    if (MissesRows(caster, maps, receiver, tile.first_row, tile.rows, request.surface_offset)) {
      continue;
    }
    const double texels =
        TexelsCovered(caster, maps[maps.size() / 2], receiver, tile.first_row, tile.rows);
    absl::Status status = DrawCaster(context, caster, shadows, AreaOf(tile, receiver),
                                     static_cast<int>(maps.size()), texels, stop);
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status ShadowRenderer::Resolve(gl::Context& context, const Tile& tile, const ShadowWork& work,
                                     size_t pass, bool shades, Targets& targets,
                                     const std::stop_token& stop) {
  const ReceiverPatch& receiver = work.request->receiver;
  gl::Program& program = shades ? shade_ : count_;
  targets.shadows.BindColor(context, kShadowsUnit);
  absl::StatusOr<gl::Buffer> block = gl::Buffer();
  if (shades) {
    const auto samples = OfPass(work.light_samples, pass);
    block = Block(context, work.emitter, samples);
    if (!block.ok()) return block.status();
    block->BindUniforms(context, kLightSamplesBinding);
    program.Set(context, "size", glm::ivec2(receiver.width, receiver.height));
    program.Set(context, "edge_u", receiver.patch.edge_u);
    program.Set(context, "edge_v", receiver.patch.edge_v);
    program.Set(context, "normal", Vec3(work.front));
    program.Set(context, "reflectance", receiver.reflectance);
    program.Set(context, "sample_count", static_cast<int>(samples.size()));
    program.Set(context, "two_sided", receiver.two_sided ? 1 : 0);
  }
  program.Set(context, "rows", RowsOf(tile));
  program.Set(context, "slot", SlotOf(tile));
  const double row_units = receiver.width / kTexelsPerUnit * (shades ? kSamplesPerPass : 1);
  gl::PixelArea band = AreaOf(tile, receiver);
  const int end = band.y + band.height;
  for (; band.y < end; band.y += band.height) {
    band.height = static_cast<int>(std::clamp(pace_.most() / row_units, 1.0, 1.0 * (end - band.y)));
    gl::Draw(context, {.program = program,
                       .vertices = no_attributes_,
                       .target = targets.sums,
                       .count = 3,
                       .depth_test = gl::DepthTest::kNone,
                       .writes_depth = false,
                       .combine = gl::Combine::kAdd,
                       .area = band});
    if (auto status = pace_.Did(context, band.height * row_units, stop); !status.ok())
      return status;
  }
  return absl::OkStatus();
}

absl::StatusOr<gl::Readback> ShadowRenderer::DrawPage(gl::Context& context, const Page& page,
                                                      std::span<const ShadowWork> works,
                                                      bool shades, const std::stop_token& stop) {
  auto targets = TargetsFor(context, page, shades);
  if (!targets.ok()) return targets.status();
  (*targets)->sums.Clear(context, Vec4(0.0f));
  size_t passes = 0;
  for (const Tile& tile : page.tiles) {
    passes = std::max(passes, works[tile.receiver].pass_count());
  }
  for (size_t pass = 0; pass < passes; ++pass) {
    (*targets)->shadows.ClearToZeros(context);
    for (const Tile& tile : page.tiles) {
      const ShadowWork& work = works[tile.receiver];
      absl::Status status = DrawTile(context, tile, work, pass, (*targets)->shadows, stop);
      if (!status.ok()) return status;
    }
    for (const Tile& tile : page.tiles) {
      absl::Status status =
          Resolve(context, tile, works[tile.receiver], pass, shades, **targets, stop);
      if (!status.ok()) return status;
    }
  }
  const gl::PixelArea all{0, 0, static_cast<int>(page.width), static_cast<int>(page.height)};
  return gl::Readback::Start(context, (*targets)->sums, all, shades ? 4 : 1);
}

absl::StatusOr<std::vector<ShadowSums>> ShadowRenderer::Draw(
    gl::Context& context, std::span<const ShadowRequest> requests, const std::stop_token& stop) {
  if (absl::Status status = context.Check("ShadowRenderer::Draw"); !status.ok()) return status;
  pace_.Start(context);
  std::vector<ShadowWork> works;
  std::vector<TexelSize> sizes;
  std::vector<ShadowSums> sums(requests.size());
  bool shades = false;
  for (size_t r = 0; r < requests.size(); ++r) {
    const ShadowRequest& request = requests[r];
    works.emplace_back(request, stop);
    sizes.push_back({request.receiver.width, request.receiver.height});
    const size_t texels = size_t{request.receiver.width} * request.receiver.height;
    sums[r].hidden.resize(texels);
    if (request.light) sums[r].radiance.resize(texels);
    shades |= request.light != nullptr;
  }
  const std::vector<Page> pages = LayOutPages(sizes);
  std::deque<std::pair<const Page*, gl::Readback>> in_flight;
  const auto land = [&](size_t most) -> absl::Status {
    while (in_flight.size() > most) {
      auto pixels = in_flight.front().second.Wait(context);
      if (!pixels.ok()) return pixels.status();
      CopyFromPage(*in_flight.front().first, *pixels, shades ? 4 : 1, works, sums);
      in_flight.pop_front();
    }
    return absl::OkStatus();
  };
  for (const Page& page : pages) {
    auto readback = DrawPage(context, page, works, shades, stop);
    if (!readback.ok()) return readback.status();
    in_flight.emplace_back(&page, *std::move(readback));
    if (absl::Status status = land(kPagesInFlight - 1); !status.ok()) return status;
  }
  if (absl::Status status = land(0); !status.ok()) return status;
  if (absl::Status status = context.Check("ShadowRenderer::Draw"); !status.ok()) return status;
  if (stop.stop_requested()) return absl::CancelledError("stop requested");
  return sums;
}

}  // namespace penumbra::texture_gl
