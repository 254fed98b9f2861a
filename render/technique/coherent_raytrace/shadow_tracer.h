// What traces shadow rays.
#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "render/scene/point_receiver.h"

namespace penumbra {

// Rays from one point, an array for each coordinate of their targets: positions on a light, or unit
// directions to one at infinity. All of them leave the front of the surface.
struct ShadowRays {
  SurfacePoint from;
  bool at_infinity = false;
  // Where a ray is blocked is asked for; otherwise only whether it is.
  bool wants_blockers = true;
  std::span<const float> x, y, z;
};

inline constexpr float kUnblocked = std::numeric_limits<float>::infinity();

struct TraceCounts {
  uint64_t rays = 0;
  uint64_t steps = 0;    // nodes of depth pyramids looked at
  uint64_t images = 0;   // depth images that rays were traced through
  uint64_t packets = 0;  // of rays against triangles

  TraceCounts& operator+=(const TraceCounts& other) {
    rays += other.rays;
    steps += other.steps;
    images += other.images;
    packets += other.packets;
    return *this;
  }
};

// Immutable: any thread may trace.
class ShadowTracer {
 public:
  virtual ~ShadowTracer() = default;

  // blocked_at[i] becomes where ray i is blocked, as a share of the way to its target, to one at
  // infinity in metres, so that the blocker is at from + blocked_at · (target − from), or
  // from + blocked_at · target; kUnblocked where nothing is in the way. Without wants_blockers any
  // number less than kUnblocked says that it is blocked.
  //
  // Shapes  n rays, any n → blocked_at of n
  virtual void Trace(const ShadowRays& rays, std::span<float> blocked_at,
                     TraceCounts& counts) const = 0;
};

}  // namespace penumbra
