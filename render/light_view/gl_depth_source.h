// Depth maps drawn by GL.
#pragma once

#include <string>
#include <vector>

#include "render/gl/context.h"
#include "render/light_view/depth_method.h"
#include "render/light_view/depth_source.h"
#include "render/light_view/gl/depth_renderer.h"
#include "render/scene/scene.h"

namespace penumbra {

// Several views are on their way at any time: the one that is taken was asked for several before.
// On the thread of its context.
//
// Cost  memory: of the GPU what MeshStore keeps, two targets, and a few bands of pixels;
//       time: a software device draws about 8 million triangles a second
class GlDepthSource : public DepthSource {
 public:
  // field  that asked for GL, for errors: "layered_attenuation.depth_source"
  GlDepthSource(const Scene& scene, gl::Context& context, std::string field);

  // Errors  besides those of every source: kResourceExhausted, GL_MEMORY at the field;
  //         kUnavailable: the context is lost; kInternal: the driver refuses a shader
  absl::Status Draw(std::span<const LightView> views, const std::stop_token& stop,
                    const Take& take) override;
  std::string drawn_by() const override { return std::string(NameOf(DepthMethod::kGl)); }

 private:
  gl::Context& context_;
  const std::string field_;
  std::vector<GlCaster> casters_;
};

}  // namespace penumbra
