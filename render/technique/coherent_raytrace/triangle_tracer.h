// Shadow rays against the scene's triangles.
#pragma once

#include <memory>

#include "render/light_view/caster_bvh.h"
#include "render/math/aabb.h"
#include "render/technique/coherent_raytrace/shadow_tracer.h"

namespace penumbra {

// How far over a surface rays begin that are to miss it, for positions in `bounds`: 2^-19 of its
// diagonal or of the largest coordinate, whichever is more. With a 32nd of that rays that graze
// planes, of two to 180,000 triangles, still missed them; with a 128th some did not.
float SurfaceOffset(const Aabb& bounds);

// Masks cut holes.
class TriangleTracer : public ShadowTracer {
 public:
  // casters         CasterBvhs::Flat, whose queries may have filters
  // surface_offset  how far over a surface its rays begin, in m
  TriangleTracer(std::shared_ptr<const CasterBvh> casters, float surface_offset)
      : casters_(std::move(casters)), surface_offset_(surface_offset) {}

  void Trace(const ShadowRays& rays, std::span<float> blocked_at,
             TraceCounts& counts) const override;

 private:
  const std::shared_ptr<const CasterBvh> casters_;
  const float surface_offset_;
};

}  // namespace penumbra
