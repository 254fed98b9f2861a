// Counts of a technique compared with rays, texel by texel, and every difference judged in double
// precision.
#pragma once

#include <cstdint>

#include "render/artifact/artifact.h"
#include "render/scene/scene.h"

namespace penumbra::testing {

struct Exactness {
  uint64_t texel_samples = 0;
  // Sum over texels of |count − count by rays|.
  uint64_t differing = 0;
  // Of these, those that no ray within rounding of an edge accounts for.
  uint64_t unexplained = 0;
  // The largest slack, in units of the last place of the largest coordinate, that was needed to
  // explain a difference.
  double largest_slack_ulps = 0;
  uint64_t occluded = 0;  // by rays: a comparison of empty shadows proves nothing

  void Add(const Exactness& other);
  double differing_fraction() const;
};

// `artifact` is the soft shadow texture of some light and receiver of `scene`, in full.
Exactness CompareWithRays(const Scene& scene, const Artifact& artifact);

}  // namespace penumbra::testing
