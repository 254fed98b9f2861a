// Each of the CPU's depth sources in turn.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "render/light_view/raster_depth_source.h"
#include "render/light_view/ray_depth_source.h"
#include "render/light_view/split_depth_source.h"
#include "tests/support/drawn_views.h"

namespace penumbra::testing {

enum class CpuSource { kRays, kRaster, kSplit };

class CpuDepthSourceTest : public ::testing::TestWithParam<CpuSource> {
 protected:
  std::unique_ptr<DepthSource> SourceOf(const Scene& scene) { return SourceOf(scene, arena_); }
  std::unique_ptr<DepthSource> SourceOf(const Scene& scene, tbb::task_arena& arena) {
    if (GetParam() == CpuSource::kRaster) return std::make_unique<RasterDepthSource>(scene, arena);
    if (GetParam() == CpuSource::kSplit) {
      return std::make_unique<SplitDepthSource>(scene, bvhs_, arena);
    }
    return std::make_unique<RayDepthSource>(bvhs_.Of(scene), arena);
  }

  DepthMap DrawOne(const Scene& scene, const LightView& view) {
    return DrawAll(*SourceOf(scene), std::span(&view, 1)).at(0);
  }

  CasterBvhs bvhs_;
  tbb::task_arena arena_{2};
};

inline const auto kCpuSources =
    ::testing::Values(CpuSource::kRays, CpuSource::kRaster, CpuSource::kSplit);

inline std::string SourceName(const ::testing::TestParamInfo<CpuSource>& source) {
  return source.param == CpuSource::kRays     ? "Rays"
         : source.param == CpuSource::kRaster ? "Raster"
                                              : "Split";
}

}  // namespace penumbra::testing
