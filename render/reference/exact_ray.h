// One ray at a time against every triangle, in double precision, with how close the call was.
//
//   const ExactRays exact(scene);
//   const auto verdicts = exact.Trace(receiver.patch, texel_center, samples, surface_offset, 1e-6);
//   if (verdicts[s].slack <= 1e-6) …  // single precision may say either
#pragma once

#include <span>
#include <vector>

#include "render/reference/occluder_triangles.h"
#include "render/scene/light_sample.h"
#include "render/scene/receiver.h"

namespace penumbra {

struct ExactVerdict {
  bool blocked = false;
  // Metres by which the ray, or the triangles, must at least be displaced to make the verdict
  // another. An estimate from below for single triangles: where several meet, each is taken alone.
  double slack = 0;
};

class ExactRays {
 public:
  explicit ExactRays(const Scene& scene);

  // The rays from `origin`, on the receiver, to `samples`, each within its BlockingInterval. A hit
  // on a masked surface has no slack if rays displaced by `tolerance` metres find other opacities;
  // slack beyond 100 tolerances is not told apart.
  //
  // Cost  O(triangles + samples · triangles near any of the rays)
  std::vector<ExactVerdict> Trace(const Parallelogram& patch, DVec3 origin,
                                  std::span<const LightSample> samples, double surface_offset,
                                  double tolerance) const;

  // The largest coordinate of all triangles, in metres: what their rounding is relative to.
  double largest_coordinate() const { return largest_coordinate_; }

 private:
  std::vector<const OccluderTriangle*> TrianglesNear(DVec3 origin,
                                                     std::span<const LightSample> samples,
                                                     double margin) const;

  std::vector<OccluderTriangle> triangles_;
  double largest_coordinate_ = 0;
};

}  // namespace penumbra
