// Shadow rays against depth images seen from a few points of the light.
//
//   auto images = DrawReferenceImages(light, *scene, {}, source, stop);
//   const DepthImageTracer tracer(*std::move(images), {});
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "render/technique/coherent_raytrace/depth_pyramid.h"
#include "render/technique/coherent_raytrace/image_traversal.h"
#include "render/technique/coherent_raytrace/shadow_tracer.h"

namespace penumbra {

// How far over a surface its rays begin. A plane seen at an angle γ to its normal is a stair whose
// steps are up to sin γ / √2 of a pixel off it along the normal; curved surfaces and neighbours of
// a silhouette need more. Of 0.4, 0.7 and 1 pixels, 0.7 comes closest to rays against triangles.
struct SelfShadowBias {
  std::optional<double> metres;  // instead of what follows
  double pixels = 0.7;           // pixels' widths at the point's depth, times ½ + sin γ / √2
  double relative = 1e-5;        // to the point's depth
};

// A ray is blocked where it goes through a surface of one image, unless another image sees it in
// the open there. So the answer does not depend on the images' order, nor on the accelerations.
//
// Source  Agrawala et al. 2000, §5.1; departs: what one image sees to be empty is empty; rays begin
//         over the surface, along its normal, instead of depths being compared with a bias; what is
//         beyond an image's edges counts as hidden unless nothing that casts is there, so that
//         lights that shine all around can be seen through several images from each place
class DepthImageTracer : public ShadowTracer {
 public:
  DepthImageTracer(std::vector<DepthPyramid> images, const RayAccelerations& accelerations,
                   const SelfShadowBias& bias = {})
      : images_(std::move(images)), accelerations_(accelerations), bias_(bias) {}

  // Rays that no image sees all of, and that are blocked in none, are free.
  void Trace(const ShadowRays& rays, std::span<float> blocked_at,
             TraceCounts& counts) const override;

  std::span<const DepthPyramid> images() const { return images_; }

 private:
  double OffsetOf(const SurfacePoint& point) const;

  const std::vector<DepthPyramid> images_;
  const RayAccelerations accelerations_;
  const SelfShadowBias bias_;
};

}  // namespace penumbra
