#include "render/light_view/make_depth_source.h"

#include <utility>

#include "render/light_view/auto_depth_source.h"
#include "render/light_view/gl_depth_source.h"
#include "render/light_view/no_gl.h"
#include "render/light_view/raster_depth_source.h"
#include "render/light_view/ray_depth_source.h"

namespace penumbra {

absl::StatusOr<std::unique_ptr<DepthSource>> MakeDepthSource(DepthMethod method, const Scene& scene,
                                                             const DepthSourceMeans& means,
                                                             std::string field) {
  switch (method) {
    case DepthMethod::kAuto:
      break;
    case DepthMethod::kRaster:
      return std::make_unique<RasterDepthSource>(scene, means.arena);
    case DepthMethod::kRays:
      return std::make_unique<RayDepthSource>(means.bvhs.Of(scene), means.arena);
    case DepthMethod::kGl:
      if (means.gl) return std::make_unique<GlDepthSource>(scene, *means.gl, std::move(field));
      if (means.cpu_for_gl) break;
      return NoGl(field, NameOf(DepthMethod::kGl), means.gl_error);
  }
  return std::make_unique<AutoDepthSource>(scene, means.bvhs, means.arena);
}

}  // namespace penumbra
