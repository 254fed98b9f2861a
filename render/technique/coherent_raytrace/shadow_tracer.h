// What traces shadow rays.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "render/scene/point_receiver.h"

namespace penumbra {

// Rays that leave the front of a surface from one point: those after the fan before it and
// before `end`.
struct RayFan {
  SurfacePoint from;
  size_t end = 0;
};

// One fan after another, an array for each coordinate of the rays' targets: positions on a light,
// or unit directions to one at infinity.
struct ShadowRays {
  std::span<const RayFan> fans;
  bool at_infinity = false;
  // Where a ray is blocked is asked for; otherwise only whether it is.
  bool wants_blockers = true;
  std::span<const float> x, y, z;
};

inline constexpr float kUnblocked = std::numeric_limits<float>::infinity();

// Where rays end, as a share of their way: the last 2^-16 of it is where a light's own surface is.
inline constexpr float kRayEnd = 1 - 0x1p-16f;

struct TraceCounts {
  uint64_t rays = 0;
  uint64_t steps = 0;   // nodes of depth pyramids looked at
  uint64_t images = 0;  // depth images that rays were traced through

  TraceCounts& operator+=(const TraceCounts& other) {
    rays += other.rays;
    steps += other.steps;
    images += other.images;
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
