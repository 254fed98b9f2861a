#include "render/light_view/gl/depth_renderer.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "render/gl/draw.h"
#include "render/light_view/light_face.h"

namespace penumbra {
namespace {

// A triangle that is drawn is a unit of work. On a software device it takes as long to find out
// which depth this many pixels have.
constexpr double kPixelsPerUnit = 4;

// Targets' sides are multiples of this, so that views of a light, of sizes that differ by a few
// pixels, share them.
constexpr int kSideStep = 64;

int RoundedUp(int side) { return (side + kSideStep - 1) / kSideStep * kSideStep; }

// About how many pixels of the band see the box; nullopt: none may. A pixel's own centre may see
// what is in the window only; a pixel around it is to spare.
std::optional<double> PixelsSeeing(const LightView& view, RowBand band, const Aabb& box) {
  const DVec2 pixel = 1.0 / view.pixels_per_slope();
  Window window = view.window;
  window.max.y = window.min.y + (band.first + band.count) * pixel.y;
  window.min.y += band.first * pixel.y;
  window = {.min = window.min - pixel, .max = window.max + pixel};
  const Window seen = view.from_infinity
                          ? Intersection(ShearedWindow(view.frame, DVec2(view.eye), box), window)
                          : WindowOf(view.frame, view.eye, 0.0, box, window);
  if (!(seen.min.x <= seen.max.x && seen.min.y <= seen.max.y)) return std::nullopt;
  const DVec2 size = seen.size() * view.pixels_per_slope();
  return size.x * size.y;
}

}  // namespace

absl::StatusOr<DepthRenderer*> DepthRenderer::Of(gl::Context& context) {
  static constexpr char kOwner = 0;
  std::shared_ptr<void>& kept = context.Kept(&kOwner);
  if (!kept) {
    std::shared_ptr<DepthRenderer> renderer(new DepthRenderer);
    renderer->meshes_ = &MeshStore::Of(context);
    if (absl::Status status = renderer->CreatePrograms(context); !status.ok()) return status;
    kept = std::move(renderer);
  }
  return static_cast<DepthRenderer*>(kept.get());
}

absl::Status DepthRenderer::CreatePrograms(gl::Context& context) {
  auto vertices = gl::VertexArray::Create(context);
  if (!vertices.ok()) return vertices.status();
  no_attributes_ = *std::move(vertices);
  for (const bool masked : {false, true}) {
    auto program = gl::Program::Create(context, DepthProgram(masked));
    if (!program.ok()) return program.status();
    (masked ? masked_ : opaque_) = *std::move(program);
  }
  return absl::OkStatus();
}

absl::StatusOr<gl::Framebuffer*> DepthRenderer::TargetFor(gl::Context& context, int width,
                                                          int height) {
  std::optional<gl::Framebuffer>& target = targets_[next_target_];
  next_target_ = (next_target_ + 1) % targets_.size();
  const bool fits =
      target && target->options().width >= width && target->options().height >= height;
  // One that is much too large would take long to clear.
  const auto pixels = [](int w, int h) { return size_t{1} * w * h; };
  if (fits && pixels(target->options().width, target->options().height) <=
                  4 * pixels(RoundedUp(width), RoundedUp(height))) {
    return &*target;
  }
  auto made = gl::Framebuffer::Create(
      context, {.width = std::min(RoundedUp(width), context.info().max_texture_side),
                .height = std::min(RoundedUp(height), context.info().max_texture_side),
                .color = gl::Format::kR32F,
                .has_depth = false});
  if (!made.ok()) return made.status();
  target = *std::move(made);
  return &*target;
}

absl::Status DepthRenderer::DrawCaster(gl::Context& context, const Instance& instance,
                                       gl::Framebuffer& target, const gl::PixelArea& area,
                                       double pixels, std::string_view field,
                                       const std::stop_token& stop) {
  auto mesh = meshes_->Mesh(context, *instance.mesh, field);
  if (!mesh.ok()) return mesh.status();
  (*mesh)->Bind(context);
  const bool is_masked = instance.alpha_mask && !instance.mesh->uvs().empty();
  gl::Program& program = is_masked ? masked_ : opaque_;
  if (is_masked) {
    auto mask = meshes_->Mask(context, *instance.alpha_mask, *instance.mesh, field);
    if (!mask.ok()) return mask.status();
    (*mask)->Bind(context, kMaskUnit);
    program.Set(context, "least_alpha", LeastAlpha(instance.alpha_cutoff));
  }
  const char* const kColumns[] = {"column0", "column1", "column2", "column3"};
  for (int c = 0; c < 4; ++c) program.Set(context, kColumns[c], instance.world_from_mesh[c]);
  const size_t triangles = instance.mesh->triangle_count();
  const auto all = static_cast<double>(triangles);
  // If each pixel that may be seen is drawn to once.
  const double units = all + pixels / kPixelsPerUnit;
  const auto at_a_time = static_cast<size_t>(std::clamp(pace_.most() / units * all, 1.0, all));
  for (size_t t = 0; t < triangles; t += at_a_time) {
    const size_t drawn = std::min(at_a_time, triangles - t);
    gl::Draw(context, {.program = program,
                       .vertices = no_attributes_,
                       .target = target,
                       .count = static_cast<int>(3 * drawn),
                       .depth_test = gl::DepthTest::kNone,
                       .writes_depth = false,
                       .combine = gl::Combine::kGreater,
                       .first = static_cast<int>(3 * t),
                       .area = area});
    absl::Status status = pace_.Did(context, units * static_cast<double>(drawn) / all, stop);
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::StatusOr<gl::Readback> DepthRenderer::Draw(gl::Context& context,
                                                 std::span<const GlCaster> casters,
                                                 const LightView& view, RowBand band,
                                                 std::string_view field,
                                                 const std::stop_token& stop) {
  const gl::PixelArea area{.width = static_cast<int>(view.width),
                           .height = static_cast<int>(band.count)};
  auto target = TargetFor(context, area.width, area.height);
  if (!target.ok()) return target.status();
  (*target)->Clear(context, Vec4(std::numeric_limits<float>::lowest()));
  const GpuDepthView gpu_view(view);
  auto block = gl::Buffer::Create(context, std::as_bytes(std::span(&gpu_view, 1)));
  if (!block.ok()) return block.status();
  block->BindUniforms(context, kDepthViewBinding);
  for (gl::Program* program : {&opaque_, &masked_}) {
    program->Set(context, "size", glm::ivec2(view.width, view.height));
    program->Set(context, "rows", glm::ivec2(band.first, band.count));
  }
  for (const GlCaster& caster : casters) {
    if (stop.stop_requested()) return absl::CancelledError("stop requested");
    const auto pixels = PixelsSeeing(view, band, caster.box);
    if (!pixels) continue;
    absl::Status status =
        DrawCaster(context, *caster.instance, **target, area, *pixels, field, stop);
    if (!status.ok()) return status;
  }
  return gl::Readback::Start(context, **target, area, 1);
}

}  // namespace penumbra
