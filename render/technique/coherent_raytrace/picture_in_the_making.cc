#include "render/technique/coherent_raytrace/picture_in_the_making.h"

#include <utility>

#include "render/scene/unoccluded_light.h"

namespace penumbra {
namespace {

// How long a viewer waits for the next tiles; more often would send the same masks again and again.
constexpr double kPublishEveryMs = 150.0;
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
      const size_t i = size_t{y} * points_.width + x;
      if (!points_.is_there[i]) continue;
      mask_->Set(i);
      view_.visibility.counts[i] = field.visible[i];
      if (view_.radiance) view_.radiance->texels[i] = strength_ * field.irradiance[i];
    }
  }
}

void PictureInTheMaking::Add(const TileDone& done, const ShadowField& so_far) {
  if (!context_.progress) return;
  Copy(done.tile, so_far);
  const double share = static_cast<double>(done.tiles_done) / static_cast<double>(done.tiles);
  const double ms = watch_.ElapsedMs();
  const bool is_due = context_.now_ms ? ms - published_ms_ >= kPublishEveryMs
                                      : share - published_share_ >= kPublishEveryShare;
  if (!is_due || done.tiles_done == done.tiles) return;
  view_.progress = {
      .fraction_done = share, .rays_traced = done.rays, .time_left_ms = ms * (1 - share) / share};
  published_ms_ = ms;
  published_share_ = share;
  context_.progress(Snapshot());
  ++header_.pass;
}

// With a mask of its own, since what was handed out stays as it is.
Artifact PictureInTheMaking::Snapshot() const {
  ViewShadow view = view_;
  view.coverage = std::make_shared<CoverageMask>(*mask_);
  if (view.radiance) RoundTo(view.radiance->format, 1.0f, *view.radiance);
  Artifact artifact{.header = header_, .payload = std::move(view)};
  artifact.header.timings_ms["compute"] = watch_.ElapsedMs();
  return artifact;
}

Artifact PictureInTheMaking::Finish(const ShadowField& field) && {
  Copy({0, 0, points_.width, points_.height}, field);
  header_.is_final = true;
  view_.progress = {.fraction_done = 1.0, .rays_traced = field.counts.rays, .time_left_ms = 0.0};
  return Snapshot();
}

}  // namespace penumbra
