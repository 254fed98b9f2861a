// Shadow rays from one point, given to a tracer.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

#include "render/technique/coherent_raytrace/light_square.h"
#include "render/technique/coherent_raytrace/shadow_tracer.h"
#include "tests/support/random_scene.h"

namespace penumbra::testing {

// Where the rays of the fans are blocked.
inline std::vector<float> TraceFans(const ShadowTracer& tracer, const ShadowRays& rays) {
  std::vector<float> blocked_at(rays.x.size());
  TraceCounts counts;
  tracer.Trace(rays, blocked_at, counts);
  EXPECT_EQ(counts.rays, rays.x.size());
  return blocked_at;
}

struct Batch {
  std::vector<float> x, y, z;
  SurfacePoint from;
  bool at_infinity;

  std::vector<float> Trace(const ShadowTracer& tracer, bool wants_blockers) const {
    const RayFan fan{from, x.size()};
    return TraceFans(tracer, {.fans = {&fan, 1},
                              .at_infinity = at_infinity,
                              .wants_blockers = wants_blockers,
                              .x = x,
                              .y = y,
                              .z = z});
  }
};

inline Batch RandomBatch(Dice& dice, const LightSquare& square, size_t count) {
  Batch batch{.from = {dice.InCube(2), dice.Direction()}, .at_infinity = square.is_at_infinity()};
  const LightSquare::Seen seen = square.From(batch.from.position);
  for (size_t i = 0; i < count; ++i) {
    const Vec3 target = seen.TargetAt({dice.Between(0, 1), dice.Between(0, 1)});
    batch.x.push_back(target.x), batch.y.push_back(target.y), batch.z.push_back(target.z);
  }
  return batch;
}

}  // namespace penumbra::testing
