// Depth maps by whichever of the CPU's ways is cheaper.
//
//   CasterBvhs bvhs;   // kept, so that hierarchies are built once
//   AutoDepthSource source(scene, bvhs, arena);
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "render/light_view/caster_bvh.h"
#include "render/light_view/depth_method.h"
#include "render/light_view/depth_source.h"
#include "render/light_view/raster_depth_source.h"
#include "render/light_view/ray_depth_source.h"
#include "tbb/task_arena.h"

namespace penumbra {

// Asks for each view CheaperOnCpu, a function of the scene and of the view: the same views give the
// same bits in any company, in any run and on any number of threads. What rays need is built when
// the first view is theirs.
//
// Cost  the least of both, as far as the model holds. One thread at a time may draw.
class AutoDepthSource : public DepthSource {
 public:
  // All outlive the source.
  AutoDepthSource(const Scene& scene, CasterBvhs& bvhs, tbb::task_arena& arena)
      : scene_(scene), bvhs_(bvhs), arena_(arena), sizes_(scene) {}

  absl::Status Draw(std::span<const LightView> views, const std::stop_token& stop,
                    const Take& take) override;
  std::string drawn_by() const override;

  // kRaster or kRays: how `view` is drawn.
  DepthMethod MethodFor(const LightView& view) const { return CheaperOnCpu(sizes_.WorkOf(view)); }

 private:
  DepthSource& SourceFor(DepthMethod method);

  const Scene& scene_;
  CasterBvhs& bvhs_;
  tbb::task_arena& arena_;
  const CasterSizes sizes_;
  std::optional<RasterDepthSource> raster_;
  std::optional<RayDepthSource> rays_;
};

}  // namespace penumbra
