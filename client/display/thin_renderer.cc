#include "client/display/thin_renderer.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/display/count_pool.h"
#include "client/display/cover_sheet.h"
#include "client/display/draw_list.h"
#include "client/display/picture_tile.h"
#include "client/display/surface_painter.h"
#include "client/display/volume_shadows.h"
#include "client/display/word_pool.h"
#include "render/gl/framebuffer.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

// Side of the square that is drawn at once, in shading samples: 84 MB at 4 edge samples of 20
// bytes, and with a stencil 101 MB.
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
        CheckRange("samples_per_side", options.samples_per_side, kMaxSamplesPerSide),
        CheckRange("volume_look.passes", options.volume_look.passes, kMaxVolumePasses)}) {
    if (!status.ok()) return status;
  }
  if (!IsFinite(options.ambient)) {
    return FieldError(absl::StatusCode::kInvalidArgument, "NON_FINITE", "ambient",
                      "need finite numbers");
  }
  const float opacity = options.volume_look.opacity;
  if (!(opacity >= 0 && opacity <= 1)) {
    return FieldError(absl::StatusCode::kInvalidArgument, "RANGE", "volume_look.opacity",
                      absl::StrCat("found ", opacity, ", need 0 to 1"));
  }
  return absl::OkStatus();
}

template <typename T>
absl::StatusOr<gl::Buffer> Upload(gl::Context& context, const std::vector<T>& values) {
  return gl::Buffer::Create(context, std::as_bytes(std::span(values)));
}

}  // namespace

class ThinRenderer::Impl {
 public:
  explicit Impl(gl::ProgramSource surface) : painter_(std::move(surface)) {}

  absl::Status Bind(gl::Context& context);
  absl::StatusOr<Picture> Render(gl::Context& context, const Scene& scene,
                                 std::span<const std::shared_ptr<const Artifact>> artifacts,
                                 const Camera& camera, const RenderOptions& options);
  Uploads uploads() const {
    return {painter_.mesh_upload_count(), painter_.mask_upload_count(),
            counts_.upload_count() + words_.upload_count() + volumes_.upload_count()};
  }

 private:
  // What all tiles of a picture have in common.
  struct Frame {
    const DrawList& list;
    const RenderOptions& options;
    DMat4 clip_from_world;
    gl::Buffer lights{}, receivers{}, candidates{};
  };

  absl::Status Prepare(gl::Context& context, const Camera& camera, Frame& frame);
  absl::Status RenderTile(gl::Context& context, const Frame& frame, const PictureTile& tile,
                          Picture& picture);
  enum class Items { kAll, kSurfaces, kWithoutShadows };
  absl::Status DrawItems(gl::Context& context, const Frame& frame, const SurfacePass& pass,
                         Items which);
  absl::Status ShadeByVolumes(gl::Context& context, const Frame& frame, const DMat4& tile_from_clip,
                              size_t number);
  absl::Status EnsureTarget(gl::Context& context, int side);
  size_t WithoutVolumes() const { return volumes_.order().size() - volumes_.lights().size(); }

  uint64_t context_serial_ = 0;
  std::optional<gl::Framebuffer> target_;
  std::optional<CoverSheet> sheet_;
  SurfacePainter painter_;
  CountPool counts_;
  WordPool words_;
  VolumeShadows volumes_;
};

// Starts anew when the context is another one than before.
absl::Status ThinRenderer::Impl::Bind(gl::Context& context) {
  if (absl::Status status = context.Check("the thin renderer"); !status.ok()) return status;
  if (context_serial_ == context.serial()) return absl::OkStatus();
  counts_.Clear();
  words_.Clear();
  volumes_.Clear();
  target_.reset();
  sheet_.reset();
  if (absl::Status status = painter_.Bind(context); !status.ok()) return status;
  auto sheet = CoverSheet::Create(context);
  if (!sheet.ok()) return sheet.status();
  sheet_ = *std::move(sheet);
  context_serial_ = context.serial();
  return absl::OkStatus();
}

// With a stencil, once something needs one.
absl::Status ThinRenderer::Impl::EnsureTarget(gl::Context& context, int side) {
  const int samples = std::min(kEdgeSamples, context.info().max_samples);
  const bool has_stencil = !volumes_.lights().empty();
  if (target_ && target_->options().width == side &&
      (target_->options().has_stencil || !has_stencil)) {
    return absl::OkStatus();
  }
  target_.reset();
  auto target = gl::Framebuffer::Create(
      context, {.width = side, .height = side, .samples = samples, .has_stencil = has_stencil});
  if (!target.ok()) return target.status();
  target_ = *std::move(target);
  return absl::OkStatus();
}

absl::Status ThinRenderer::Impl::Prepare(gl::Context& context, const Camera& camera, Frame& frame) {
  const DrawList& list = frame.list;
  if (absl::Status status = volumes_.Update(context, list, camera); !status.ok()) return status;
  if (absl::Status status = counts_.Update(context, list); !status.ok()) return status;
  absl::Status status = words_.Update(context, list, camera, volumes_.order());
  if (!status.ok()) return status;
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
  frame.lights = *std::move(lights);
  frame.receivers = *std::move(receivers);
  frame.candidates = *std::move(candidates);
  // What is added up light by light is cut once it is all there.
  const bool adds_up = !volumes_.lights().empty();
  painter_.SetFrame(context, camera,
                    {.ambient = frame.options.ambient,
                     .clip_radiance = adds_up ? std::numeric_limits<float>::infinity()
                                              : frame.options.clip_radiance,
                     .culls_back_faces = frame.options.culls_back_faces});
  return volumes_.Aim(context, frame.clip_from_world, frame.options.volume_look.passes);
}

// Those in sight. A pass of one light draws over surfaces that are there, so that nothing glows,
// and where nothing is received all of it arrives.
absl::Status ThinRenderer::Impl::DrawItems(gl::Context& context, const Frame& frame,
                                           const SurfacePass& pass, Items which) {
  for (const DrawItem& item : frame.list.items) {
    const bool has_shadows = item.receives && !item.glows;
    if (which == Items::kSurfaces && item.glows) continue;
    if (which == Items::kWithoutShadows && has_shadows) continue;
    if (IsOutside(pass.clip_from_world, item.bounds)) continue;
    SurfacePass own = pass;
    if (which == Items::kSurfaces && !has_shadows) own.combine = gl::Combine::kAddColor;
    if (absl::Status status = painter_.Draw(context, item, own); !status.ok()) return status;
  }
  return absl::OkStatus();
}

// Alpha, which is 1 on all surfaces, is what part of the passes finds them lit, until it is 1
// again.
absl::Status ThinRenderer::Impl::ShadeByVolumes(gl::Context& context, const Frame& frame,
                                                const DMat4& tile_from_clip, size_t number) {
  const VolumeLook& look = frame.options.volume_look;
  const float opacity = look.shading == VolumeShading::kComposited ? look.opacity : 1.0f;
  const Vec4 taken(0, 0, 0, opacity / static_cast<float>(look.passes));
  for (int pass = 0; pass < look.passes; ++pass) {
    volumes_.Mark(context, *target_, tile_from_clip, volumes_.lights()[number], pass);
    sheet_->Draw(context, *target_, taken,
                 {.combine = gl::Combine::kTakeFromAlpha, .stencil = gl::Stencil::kWhereIsSet});
  }
  const Vec4 whole(0, 0, 0, 1);
  if (look.shading != VolumeShading::kAmbient) {
    sheet_->Draw(context, *target_, whole, {.combine = gl::Combine::kMultiplyByAlpha});
    return absl::OkStatus();
  }
  const auto place = static_cast<int>(WithoutVolumes() + number);
  target_->ClearStencil(context, 0);  // surfaces at the same place are lit once
  const absl::Status status = DrawItems(context, frame,
                                        {.clip_from_world = tile_from_clip * frame.clip_from_world,
                                         .target = *target_,
                                         .first_light = place,
                                         .end_light = place + 1,
                                         .adds_ambient = false,
                                         .depth_test = gl::DepthTest::kEqual,
                                         .combine = gl::Combine::kAddColorTimesAlpha,
                                         .stencil = gl::Stencil::kOnce},
                                        Items::kSurfaces);
  sheet_->Draw(context, *target_, whole, {.combine = gl::Combine::kReplaceAlpha});
  return status;
}

absl::Status ThinRenderer::Impl::RenderTile(gl::Context& context, const Frame& frame,
                                            const PictureTile& tile, Picture& picture) {
  const RenderOptions& options = frame.options;
  const DMat4 tile_from_clip = TileFromClip(tile, options.width, options.height);
  const bool adds = options.volume_look.shading == VolumeShading::kAmbient;
  SurfacePass pass{
      .clip_from_world = tile_from_clip * frame.clip_from_world,
      .target = *target_,
      .end_light = static_cast<int>(adds ? WithoutVolumes() : frame.list.lights.size())};
  target_->Clear(context, Vec4(0));
  absl::Status status = DrawItems(context, frame, pass, Items::kAll);
  for (size_t number = 0; number < volumes_.lights().size() && status.ok(); ++number) {
    status = ShadeByVolumes(context, frame, tile_from_clip, number);
  }
  if (status.ok() && !adds) {
    // What was darkened and should not have been.
    pass.depth_test = gl::DepthTest::kEqual;
    status = DrawItems(context, frame, pass, Items::kWithoutShadows);
  }
  if (!status.ok()) return status;
  if (!volumes_.lights().empty()) {
    const Vec4 most(Vec3(options.clip_radiance), 1);
    sheet_->Draw(context, *target_, most, {.combine = gl::Combine::kLess});
  }
  const auto samples = target_->ReadPixels(context);
  if (!samples.ok()) return samples.status();
  ResolveTile(*samples, options.samples_per_side, tile, picture);
  return absl::OkStatus();
}

absl::StatusOr<Picture> ThinRenderer::Impl::Render(
    gl::Context& context, const Scene& scene,
    std::span<const std::shared_ptr<const Artifact>> artifacts, const Camera& camera,
    const RenderOptions& options) {
  const DrawList list = BuildDrawList(scene, artifacts, options.draws_lights);
  const double aspect = static_cast<double>(options.width) / options.height;
  Frame frame{.list = list, .options = options, .clip_from_world = ClipFromWorld(camera, aspect)};
  if (absl::Status status = Prepare(context, camera, frame); !status.ok()) return status;
  const int n = options.samples_per_side;
  const int side = std::min(kTileSide / n, std::max(options.width, options.height));  // pixels
  if (absl::Status status = EnsureTarget(context, side * n); !status.ok()) return status;

  Picture picture = {.width = options.width, .height = options.height, .pixels = {}};
  picture.pixels.resize(static_cast<size_t>(options.width) * options.height);
  for (int y = 0; y < options.height; y += side) {
    for (int x = 0; x < options.width; x += side) {
      const PictureTile tile = {.x = x,
                                .y = y,
                                .width = std::min(side, options.width - x),
                                .height = std::min(side, options.height - y),
                                .side = side};
      const absl::Status status = RenderTile(context, frame, tile, picture);
      if (!status.ok()) return status;
    }
  }
  painter_.EndFrame();
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

}  // namespace penumbra
