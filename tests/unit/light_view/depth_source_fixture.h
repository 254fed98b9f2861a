// Each of the CPU's depth sources in turn.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "render/light_view/raster_depth_source.h"
#include "render/light_view/ray_depth_source.h"
#include "tests/support/nearest_depth.h"

namespace penumbra::testing {

enum class CpuSource { kRays, kRaster };

class CpuDepthSourceTest : public ::testing::TestWithParam<CpuSource> {
 protected:
  std::unique_ptr<DepthSource> SourceOf(const Scene& scene) { return SourceOf(scene, arena_); }
  std::unique_ptr<DepthSource> SourceOf(const Scene& scene, tbb::task_arena& arena) {
    if (GetParam() == CpuSource::kRaster) return std::make_unique<RasterDepthSource>(scene, arena);
    return std::make_unique<RayDepthSource>(bvhs_.Of(scene), arena);
  }

  static std::vector<DepthMap> Draw(DepthSource& source, std::span<const LightView> views) {
    std::vector<DepthMap> maps;
    const auto status = source.Draw(views, {}, [&](size_t index, DepthMap map) {
      EXPECT_EQ(index, maps.size());
      maps.push_back(std::move(map));
      return absl::OkStatus();
    });
    EXPECT_TRUE(status.ok()) << status;
    return maps;
  }
  DepthMap DrawOne(const Scene& scene, const LightView& view) {
    return Draw(*SourceOf(scene), std::span(&view, 1)).at(0);
  }

  CasterBvhs bvhs_;
  tbb::task_arena arena_{2};
};

inline const auto kCpuSources = ::testing::Values(CpuSource::kRays, CpuSource::kRaster);

inline std::string SourceName(const ::testing::TestParamInfo<CpuSource>& source) {
  return source.param == CpuSource::kRays ? "Rays" : "Raster";
}

}  // namespace penumbra::testing
