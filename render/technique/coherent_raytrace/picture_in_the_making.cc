#include "render/technique/coherent_raytrace/picture_in_the_making.h"

#include <algorithm>
#include <utility>

#include "render/scene/unoccluded_light.h"

namespace penumbra {
namespace {

// How long a viewer waits for the next tiles; more often would send the same masks again and again.
constexpr double kPublishEveryMs = 150.0;
// Publishing copies the whole picture, and no tile is taken over meanwhile: its share of the time.
constexpr double kPublishingShare = 0.05;
// Without a clock: for each such share of the tiles.
constexpr double kPublishEveryShare = 0.125;

}  // namespace

PictureInTheMaking::PictureInTheMaking(ArtifactHeader header, ViewShadow view,
                                       const SurfacePoints& points, RadianceFormat format,
                                       const ComputeContext& context)
    : points_(points),
      context_(context),
      strength_(LightStrength(view.light)),
      watch_(context.now_ms),
      header_(std::move(header)),
      view_(std::move(view)),
      mask_(std::make_shared<CoverageMask>(points.width, points.height)) {
  view_.visibility = {.width = points.width,
                      .height = points.height,
                      .sample_count = header_.samples_requested,
                      .counts = std::vector<uint16_t>(points.size())};
  if (!view_.radiance) return;
  view_.radiance = RadianceTexture{.width = points.width,
                                   .height = points.height,
                                   .texels = std::vector<Vec3>(points.size()),
                                   .format = format};
}

void PictureInTheMaking::Copy(const PixelRect& tile, const ShadowField& field) {
  for (uint32_t y = tile.y; y < tile.y + tile.height; ++y) {
    for (uint32_t x = tile.x; x < tile.x + tile.width; ++x) {
      const size_t i = points_.Visited(size_t{y} * points_.width + x);
      if (!points_.is_there[i]) continue;
      mask_->Set(i);
      view_.visibility.counts[i] = field.visible[i];
      if (view_.radiance) {
        view_.radiance->texels[i] = AsHeld(strength_ * field.irradiance[i]);
      }
    }
  }
}

void PictureInTheMaking::Add(const TileDone& done, const ShadowField& so_far) {
  if (!context_.progress) return;
  Copy(done.tile, so_far);
  const double share = static_cast<double>(done.tiles_done) / static_cast<double>(done.tiles);
  if (done.tiles_done == done.tiles || !IsDue(share)) return;
  const double ms = watch_.ElapsedMs();
  view_.progress = {
      .fraction_done = share, .rays_traced = done.rays, .time_left_ms = ms * (1 - share) / share};
  context_.progress(Publish(view_));
  ++header_.pass;
  published_share_ = share;
  published_ms_ = watch_.ElapsedMs();
  publishing_ms_ = published_ms_ - ms;
}

bool PictureInTheMaking::IsDue(double share) const {
  if (!context_.now_ms) return share - published_share_ >= kPublishEveryShare;
  const double pause = std::max(kPublishEveryMs, publishing_ms_ / kPublishingShare);
  return watch_.ElapsedMs() - published_ms_ >= pause;
}

Vec3 PictureInTheMaking::AsHeld(Vec3 radiance) const {
  const RadianceFormat format = view_.radiance->format;
  return format == RadianceFormat::kFloat32 ? radiance
                                            : Rounded(RadianceCodec(format, 1.0f), radiance);
}

// With a mask of its own, since what was handed out stays as it is.
Artifact PictureInTheMaking::Publish(ViewShadow view) const {
  view.coverage = std::make_shared<CoverageMask>(*mask_);
  Artifact artifact{.header = header_, .payload = std::move(view)};
  artifact.header.timings_ms["compute"] = watch_.ElapsedMs();
  return artifact;
}

Artifact PictureInTheMaking::Finish(const ShadowField& field) && {
  Copy({0, 0, points_.width, points_.height}, field);
  header_.is_final = true;
  view_.progress = {.fraction_done = 1.0, .rays_traced = field.counts.rays, .time_left_ms = 0.0};
  return Publish(std::move(view_));
}

}  // namespace penumbra
