// What occluders hide from a receiver, counted by GL: the `gl` method's place in soft_texture.
//
//   GlShadows shadows(context, scene, receiver, surface_offset, radiance ? light : nullptr);
//   if (auto status = shadows.Add(samples, stop); !status.ok()) return status;
//   shadows.counts()
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "absl/status/status.h"
#include "render/artifact/soft_shadow_texture.h"
#include "render/gl/context.h"
#include "render/scene/light_sample.h"
#include "render/scene/receiver.h"
#include "render/scene/scene.h"

namespace penumbra {

class GlShadows {
 public:
  // `light`  that the samples will be of, where radiance is wanted; otherwise null
  GlShadows(gl::Context& context, const Scene& scene, const ReceiverPatch& receiver,
            double surface_offset, const AreaLight* light)
      : context_(context),
        scene_(scene),
        receiver_(receiver),
        surface_offset_(surface_offset),
        light_(light),
        counts_(size_t{receiver.width} * receiver.height, uint16_t{0}) {}

  // Adds what hides `samples`. Errors  those of ShadowRenderer
  absl::Status Add(std::span<const LightSample> samples, const std::stop_token& stop);

  // H·W samples hidden, row by row.
  const std::vector<uint16_t>& counts() const { return counts_; }

  // The mean of the visible samples' terms, of all samples added so far: equation (3.2).
  RadianceTexture Radiance() const;

 private:
  gl::Context& context_;
  const Scene& scene_;
  const ReceiverPatch& receiver_;
  double surface_offset_;
  const AreaLight* light_;
  size_t sample_count_ = 0;
  std::vector<uint16_t> counts_;
  std::vector<Vec3> sums_;
};

}  // namespace penumbra
