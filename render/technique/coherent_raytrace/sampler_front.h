// Many points' shadow rays, traced together.
//
//   auto front = MakeSamplerFront(square, tracer, {.side = 16}, &proof);
//   for (…) front->Begin(lane, point, index);  // from the last lane to the first
//   front->Finish();
//   const CellMask visible = front->visible(lane);
#pragma once

#include <cstdint>
#include <memory>

#include "render/scene/point_receiver.h"
#include "render/technique/coherent_raytrace/cell_mask.h"
#include "render/technique/coherent_raytrace/light_square.h"
#include "render/technique/coherent_raytrace/sampling_settings.h"
#include "render/technique/coherent_raytrace/shadow_tracer.h"

namespace penumbra {

class LightProof;

// Samplers side by side, one for each row of a patch of points, that go along their rows at the
// same time. What one point asks for is a few rays here and a few there; what all ask for together
// makes full packets. Each row runs one point behind the row before, so that a point that is too
// far from the one before in its row can continue from the one above it.
//
// Not for several threads at once.
class SamplerFront {
 public:
  static constexpr uint32_t kLanes = 32;

  virtual ~SamplerFront() = default;

  // Forgets the points before.
  virtual void Restart() = 0;

  // A lane's next point. The lanes after it must have begun theirs already, and the one before it
  // must not.
  virtual void Begin(uint32_t lane, const SurfacePoint& point, uint64_t point_index) = 0;
  // Traces all that the points begun ask for.
  virtual void Finish() = 0;

  // The cells whose samples the lane's point sees.
  virtual CellMask visible(uint32_t lane) const = 0;
  // Traced for the lane's point.
  virtual uint32_t rays(uint32_t lane) const = 0;
  // What was counted since the last time.
  virtual TraceCounts TakeCounts() = 0;
};

// Of the quickest instructions that the machine has.
//
// square, tracer  outlive what is made
// proof           what is known without rays, as long; null: nothing
std::unique_ptr<SamplerFront> MakeSamplerFront(const LightSquare& square,
                                               const ShadowTracer& tracer,
                                               const SamplingSettings& settings,
                                               const LightProof* proof);

}  // namespace penumbra
