// Depth maps by drawing triangles.
#pragma once

#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "render/light_view/depth_method.h"
#include "render/light_view/depth_source.h"
#include "render/light_view/placed_caster.h"
#include "render/scene/scene.h"
#include "tbb/task_arena.h"

namespace penumbra {

// Several views at a time, each on one thread. No ray is too close to an edge: triangles that share
// one leave no pixel out between them.
//
// Cost  time: RasterNs in depth_method.h; memory: 12 bytes for each vertex of each cluster, and as
//       many maps as there are threads, up to 256 MB. One thread at a time may draw.
class RasterDepthSource : public DepthSource {
 public:
  RasterDepthSource(const Scene& scene, tbb::task_arena& arena);

  absl::Status Draw(std::span<const LightView> views, const std::stop_token& stop,
                    const Take& take) override;
  std::string drawn_by() const override { return std::string(NameOf(DepthMethod::kRaster)); }

 private:
  // Places the casters in `frame`, unless they are. Errors  kCancelled
  absl::Status PlaceIn(const RasterFrame& frame, const std::stop_token& stop);
  // Views of one frame, the first of which is views[first_index] of Draw's.
  absl::Status DrawPlaced(std::span<const LightView> views, size_t first_index,
                          const std::stop_token& stop, const Take& take);

  std::vector<std::shared_ptr<const Instance>> casters_;
  tbb::task_arena& arena_;
  std::optional<RasterFrame> frame_;  // that `placed_` are in
  std::vector<std::optional<PlacedCaster>> placed_;
};

}  // namespace penumbra
