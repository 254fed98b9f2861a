// Depth maps by rays.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "render/light_view/caster_bvh.h"
#include "render/light_view/depth_method.h"
#include "render/light_view/depth_source.h"
#include "tbb/task_arena.h"

namespace penumbra {

inline constexpr uint32_t kNoInstance = ~0u;

// Packets of 16 rays, one for each pixel of a 4×4 block.
//
// Cost  time: RaysNs in depth_method.h, nearly whatever the triangles; memory: one map. One thread
//       at a time may draw.
class RayDepthSource : public DepthSource {
 public:
  RayDepthSource(std::shared_ptr<const CasterBvh> casters, tbb::task_arena& arena)
      : casters_(std::move(casters)), arena_(arena) {}

  // Errors  besides those of every source: that of the hierarchies
  absl::Status Draw(std::span<const LightView> views, const std::stop_token& stop,
                    const Take& take) override;
  std::string drawn_by() const override { return std::string(NameOf(DepthMethod::kRays)); }

  // Of each pixel of the view, row by row, the number of the instance that it shows; kNoInstance
  // where it shows nothing.
  //
  // Errors  those of Draw
  absl::StatusOr<std::vector<uint32_t>> InstancesIn(const LightView& view,
                                                    const std::stop_token& stop) const;

 private:
  std::vector<DepthMap> DrawTogether(std::span<const LightView> views, const std::stop_token& stop);

  const std::shared_ptr<const CasterBvh> casters_;
  tbb::task_arena& arena_;
};

}  // namespace penumbra
