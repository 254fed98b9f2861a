// Depth maps by whichever of the CPU's ways is cheapest.
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
#include "render/light_view/split_depth_source.h"
#include "tbb/task_arena.h"

namespace penumbra {

// Asks for each view a model of what it costs, a function of the scene and of the view: the same
// views give the same bits in any company, in any run and on any number of threads. What rays need
// is built when the first view is theirs.
//
// Cost  the least of all, as far as the model holds. One thread at a time may draw.
class AutoDepthSource : public DepthSource {
 public:
  // All outlive the source.
  AutoDepthSource(const Scene& scene, CasterBvhs& bvhs, tbb::task_arena& arena)
      : scene_(scene), arena_(arena), split_(scene, bvhs, arena) {}

  absl::Status Draw(std::span<const LightView> views, const std::stop_token& stop,
                    const Take& take) override;
  std::string drawn_by() const override;

  // Whether `view` is drawn as a whole, not split.
  bool IsDrawn(const LightView& view) const {
    return RasterNs(split_.sizes().WorkOf(view)) <= split_.CostNs(view);
  }

 private:
  DepthSource& SourceFor(bool is_drawn);

  const Scene& scene_;
  tbb::task_arena& arena_;
  std::optional<RasterDepthSource> raster_;
  // Rays alone are this where nothing is simple.
  SplitDepthSource split_;
  bool uses_split_ = false;
};

}  // namespace penumbra
