// A view shadow while its tiles come in, published from time to time.
//
//   PictureInTheMaking picture(header, view_shadow, context);
//   settings.on_tile = [&](const TileDone& done, const ShadowField& so_far) {
//     picture.Add(done, so_far);
//   };
//   Artifact artifact = std::move(picture).Finish(field);
#pragma once

#include <cstdint>
#include <memory>

#include "render/artifact/artifact.h"
#include "render/technique/coherent_raytrace/shadow_field.h"
#include "render/technique/coherent_raytrace/surface_points.h"
#include "render/technique/stopwatch.h"
#include "render/technique/technique.h"

namespace penumbra {

class PictureInTheMaking {
 public:
  // `view` has its light and points; `points` are all there are. Refers to all but the first two.
  PictureInTheMaking(ArtifactHeader header, ViewShadow view, const SurfacePoints& points,
                     RadianceFormat format, const ComputeContext& context);

  // Takes over what is done; now and then hands all that there is to the context's progress.
  void Add(const TileDone& done, const ShadowField& so_far);

  // All of it. `field` is complete.
  Artifact Finish(const ShadowField& field) &&;

 private:
  void Copy(const PixelRect& tile, const ShadowField& field);
  Vec3 AsHeld(Vec3 radiance) const;
  bool IsDue(double share) const;
  Artifact Publish(ViewShadow view) const;

  const SurfacePoints& points_;
  const ComputeContext& context_;
  const Vec3 strength_;  // of the light
  Stopwatch watch_;      // since the beginning
  // The last time that it was published: when that was done, how long it took, what was there.
  double published_ms_ = 0.0;
  double publishing_ms_ = 0.0;
  double published_share_ = 0.0;
  ArtifactHeader header_;
  ViewShadow view_;
  std::shared_ptr<CoverageMask> mask_;
};

}  // namespace penumbra
