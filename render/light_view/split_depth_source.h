// Depth maps by both of the CPU's ways: what has few triangles is drawn, and rays are traced where
// anything else may be seen.
//
//   SplitDepthSource source(scene, bvhs, arena);   // a model on a floor
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/light_view/caster_bvh.h"
#include "render/light_view/depth_method.h"
#include "render/light_view/depth_source.h"
#include "render/light_view/raster_depth_source.h"
#include "render/light_view/ray_depth_source.h"
#include "render/scene/scene.h"
#include "tbb/task_arena.h"

namespace penumbra {

// A pixel within the box around all that is not simple is that of a ray, as RayDepthSource's; the
// others are drawn.
//
// Cost  time: CostNs; one thread at a time may draw
class SplitDepthSource : public DepthSource {
 public:
  // Casters of so many triangles without masks are simple: drawing these takes as long as some
  // hundred rays.
  static constexpr size_t kFewTriangles = 256;

  // All outlive the source. What rays need is built when the first view is drawn.
  SplitDepthSource(const Scene& scene, CasterBvhs& bvhs, tbb::task_arena& arena);

  absl::Status Draw(std::span<const LightView> views, const std::stop_token& stop,
                    const Take& take) override;
  std::string drawn_by() const override;

  // Nanoseconds of one thread, by the model of depth_method.h.
  double CostNs(const LightView& view) const;
  // Of all casters.
  const CasterSizes& sizes() const { return sizes_; }

 private:
  // Views together, the first of which is views[first] of Draw's.
  absl::StatusOr<std::vector<DepthMap>> DrawTogether(std::span<const LightView> views,
                                                     const std::stop_token& stop);

  const Scene& scene_;
  CasterBvhs& bvhs_;
  tbb::task_arena& arena_;
  const std::shared_ptr<const Scene> simple_;  // those of few triangles alone
  Aabb others_;                                // bounds of the rest
  const CasterSizes sizes_, simple_sizes_;
  RasterDepthSource raster_;
  std::optional<RayDepthSource> rays_;
};

}  // namespace penumbra
