// Visibility by tracing: a ray from each texel centre to each light sample. The oracle for
// exactness, and the peer for speed.
//
//   const RayVisibility rays(scene, RayVisibility::Intersector::kRobust);
//   VisibilityMap counts = rays.Counts(receiver, samples, surface_offset, arena);
//
// Rays go in packets of 16, one for each texel of a 4×4 block, all to the same sample, which is how
// Embree traces coherent shadow rays fastest (measured against rays one at a time, packets of 4 and
// 8, and streams).
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "render/artifact/soft_shadow_texture.h"
#include "render/scene/light_sample.h"
#include "render/scene/receiver.h"
#include "render/scene/scene.h"
#include "tbb/task_arena.h"

namespace penumbra {

class RayVisibility {
 public:
  enum class Intersector {
    kRobust,  // no ray slips between neighbouring triangles
    kFast,    // Embree's default
  };

  // Builds the hierarchy over all casting instances; keeps their masks alive.
  RayVisibility(const Scene& scene, Intersector intersector);
  ~RayVisibility();
  RayVisibility(const RayVisibility&) = delete;
  RayVisibility& operator=(const RayVisibility&) = delete;

  // How many of `samples` each texel centre sees. What is nearer than `surface_offset` metres to
  // the receiver's plane blocks nothing; neither does what lies in the last part of a ray, 2^-16 of
  // its length, where a light's own surface is.
  //
  // Shapes  n samples, a receiver of H×W texels → H×W counts in [0, n]
  VisibilityMap Counts(const ReceiverPatch& receiver, std::span<const LightSample> samples,
                       double surface_offset, tbb::task_arena& arena) const;

  // Whether the ray from texel t = j·W + i to sample s is blocked, at [s·H·W + t].
  std::vector<uint8_t> Blocked(const ReceiverPatch& receiver, std::span<const LightSample> samples,
                               double surface_offset, tbb::task_arena& arena) const;

  size_t triangle_count() const { return triangle_count_; }

 private:
  struct Embree;
  std::unique_ptr<Embree> embree_;
  size_t triangle_count_ = 0;
};

// The interval of the ray parameter within which something blocks the ray to `sample`: points at
// p + t·(sample − p), or p + t·direction. Empty (near ≥ far) for a sample that is no further than
// `surface_offset` from the receiver's plane (a direction: that many metres per metre).
struct RayInterval {
  double near;
  double far;
};
RayInterval BlockingInterval(const Parallelogram& patch, const LightSample& sample,
                             double surface_offset);

}  // namespace penumbra
