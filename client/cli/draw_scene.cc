#include "client/cli/draw_scene.h"

#include <algorithm>
#include <utility>

#include "client/cli/open_engine.h"
#include "client/cli/option_error.h"
#include "client/display/image_io.h"
#include "client/display/suggest_ambient.h"
#include "client/display/thin_renderer.h"
#include "client/display/tone.h"
#include "client/session/steady_clock.h"
#include "render/gl/context.h"

namespace penumbra {
namespace {

constexpr float kDegreesPerRadian = 57.29577951308232f;

class GlPencil : public Pencil {
 public:
  GlPencil(std::unique_ptr<gl::Context> context, std::unique_ptr<ThinRenderer> renderer)
      : context_(std::move(context)), renderer_(std::move(renderer)) {}

  DrawRoom room() const override {
    return {.bytes = static_cast<uint64_t>(context_->info().max_storage_bytes),
            .device = context_->info().renderer};
  }
  absl::StatusOr<DrawnPicture> Draw(const Scene& scene, const Shadows& shadows,
                                    const DrawRequest& request,
                                    const std::filesystem::path& path) override;

 private:
  const std::unique_ptr<gl::Context> context_;
  const std::unique_ptr<ThinRenderer> renderer_;
};

// Enough to tell how bright a picture is: a quarter as wide and high, drawn in a sixteenth of the
// time.
RenderOptions SmallVersionOf(RenderOptions options) {
  options.width = (options.width + 3) / 4;
  options.height = (options.height + 3) / 4;
  return options;
}

absl::StatusOr<DrawnPicture> GlPencil::Draw(const Scene& scene, const Shadows& shadows,
                                            const DrawRequest& request,
                                            const std::filesystem::path& path) {
  const double start_ms = NowMs();
  const RenderOptions options{.width = static_cast<int>(request.size.width),
                              .height = static_cast<int>(request.size.height),
                              .ambient = request.ambient.value_or(SuggestAmbient(scene)),
                              .volume_look = request.volume_look,
                              .culls_back_faces = request.culls_back_faces};
  const auto render = [&](const RenderOptions& chosen) {
    return renderer_->Render(*context_, scene, shadows, request.camera, chosen);
  };
  float exposure = request.exposure.value_or(1.0f);
  if (!request.exposure) {
    const auto small = render(SmallVersionOf(options));
    if (!small.ok()) return small.status();
    exposure = SuggestExposure(*small);
  }
  const bool is_for_screen = path.extension() != ".exr";
  RenderOptions clipped = options;
  if (is_for_screen) clipped.clip_radiance = 1.0f / exposure;
  const auto picture = render(clipped);
  if (!picture.ok()) return picture.status();
  const double draw_ms = NowMs() - start_ms;
  const absl::Status status = is_for_screen ? WritePng(path, picture->width, picture->height,
                                                       ToSrgb(*picture, {.exposure = exposure}))
                                            : WriteExr(path, *picture);
  if (!status.ok()) return status;
  return DrawnPicture{.camera = request.camera,
                      .exposure = exposure,
                      .renderer = context_->info().renderer,
                      .draw_ms = draw_ms};
}

}  // namespace

absl::Status CheckPicturePath(const std::filesystem::path& path) {
  if (path.extension() == ".png" || path.extension() == ".exr") return absl::OkStatus();
  return OptionError("--out", "FORMAT", {path.native()}, ", need a name that ends in .png or .exr");
}

Camera ChooseCamera(const ImportedScene& imported, bool has_floor, GridSize size) {
  Aabb bounds = Bounds(imported);
  if (!imported.cameras.empty()) {
    const ImportedCamera& camera = imported.cameras.front();
    const float distance =
        bounds.empty() ? 1.0f : std::max(0.1f, glm::distance(bounds.center(), camera.position));
    return {.eye = camera.position,
            .target = camera.position + distance * camera.forward,
            .up = camera.up,
            .fov_y_deg = camera.fov_y * kDegreesPerRadian};
  }
  if (has_floor && !bounds.empty()) {
    // Room for the shadow around what casts it.
    const Vec3 margin = 0.3f * bounds.extent() * Vec3(1, 0, 1);
    bounds = {.min = bounds.min - margin, .max = bounds.max + margin};
  }
  return FrameScene(bounds, static_cast<float>(size.width) / static_cast<float>(size.height));
}

absl::StatusOr<std::unique_ptr<Pencil>> Pencil::Create() {
  auto context = gl::Context::Create();
  if (!context.ok()) return context.status();
  auto renderer = ThinRenderer::Create(**context);
  if (!renderer.ok()) return renderer.status();
  return std::make_unique<GlPencil>(*std::move(context), *std::move(renderer));
}

}  // namespace penumbra
