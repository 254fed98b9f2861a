// Depth maps drawn by GL, against the nearest triangle in double precision and the CPU's sources.
#include "render/light_view/gl_depth_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <vector>

#include "render/light_view/raster_depth_source.h"
#include "render/light_view/view_fit.h"
#include "render/scene/field_error.h"
#include "tests/gl/display/software_context.h"
#include "tests/support/drawn_views.h"
#include "tests/support/nearest_depth.h"
#include "tests/support/random_scene.h"
#include "tests/support/shapes.h"
#include "tests/support/test_device.h"

namespace penumbra::testing {
namespace {

class GlDepthSourceTest : public SoftwareContextTest {
 protected:
  std::vector<DepthMap> DrawByGl(const Scene& scene, std::span<const LightView> views) {
    GlDepthSource source(scene, *context_, "a.method");
    return DrawAll(source, views);
  }

  tbb::task_arena arena_{2};
};

// Straight down from the origin.
LightView Down(double slope, uint32_t width, uint32_t height, double near, double far) {
  return {.frame = {.origin = DVec3(0), .axes = {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}}},
          .window = {.min = DVec2(-slope), .max = DVec2(slope)},
          .width = width,
          .height = height,
          .near = near,
          .far = far};
}

std::shared_ptr<const Scene> SceneOf(std::vector<Instance> instances) {
  SceneDelta delta;
  delta.upsert_instances = std::move(instances);
  return Scene::Empty("s")->Apply(delta).value();
}

TEST_F(GlDepthSourceTest, EveryPixelIsTheNearestTriangleInRandomScenes) {
  DepthComparison all;
  for (uint64_t seed = 0; seed < 24; ++seed) {
    const auto scene = RandomScene(seed);
    const auto triangles = OccluderTriangles(*scene);
    for (const DepthMap& map : DrawByGl(*scene, SampledViews(*scene, seed, 24))) {
      const DepthComparison one = CompareWithNearest(map, triangles);
      all.compared += one.compared;
      all.differing += one.differing;
      all.seen += one.seen;
    }
  }
  std::cout << all.compared << " pixels, " << all.seen << " see something, " << all.differing
            << " differ\n";
  EXPECT_GT(all.compared, 10'000u);
  EXPECT_GT(all.seen, all.compared / 20);
  EXPECT_LE(all.differing, all.compared / 10'000);
}

TEST_F(GlDepthSourceTest, AgreesWithTheCpuOnRandomScenes) {
  size_t pixels = 0, differing = 0, seen = 0;
  for (uint64_t seed = 100; seed < 112; ++seed) {
    const auto scene = RandomScene(seed);
    const auto views = SampledViews(*scene, seed, 120);
    RasterDepthSource raster(*scene, arena_);
    const auto by_cpu = DrawAll(raster, views), by_gl = DrawByGl(*scene, views);
    for (size_t i = 0; i < views.size(); ++i) {
      pixels += by_cpu[i].depths.size();
      seen += std::ranges::count_if(by_cpu[i].depths, [](float d) { return d != kNoDepth; });
      differing += DifferingDepths(by_cpu[i], by_gl[i]);
    }
  }
  std::cout << pixels << " pixels, " << seen << " see something, " << differing << " differ\n";
  EXPECT_GT(seen, pixels / 20);
  EXPECT_LE(differing, pixels / 2'000);
}

// Views of several sizes, of more pixels than are drawn at a time.
TEST_F(GlDepthSourceTest, LargeViewsComeInBandsInTheirOrder) {
  const auto scene = SceneOf({{.id = "box",
                               .mesh = MeshOf(UnitBoxGeometry()),
                               .world_from_mesh = Placed({0.3f, -4, 0.1f}, 1)}});
  const std::array views{Down(0.5, 30, 20, 0.1, 5), Down(0.5, 2500, 3100, 0.1, 5), LightView{},
                         Down(0.5, 1, 1, 0.1, 5)};
  RasterDepthSource raster(*scene, arena_);
  const auto expected = DrawAll(raster, views), found = DrawByGl(*scene, views);
  ASSERT_EQ(found.size(), views.size());
  for (size_t i = 0; i < views.size(); ++i) {
    ASSERT_EQ(found[i].depths.size(), expected[i].depths.size()) << i;
    EXPECT_LE(DifferingDepths(expected[i], found[i]), found[i].depths.size() / 100'000) << i;
  }
}

// A plane in triangles that pass the eye and reach far beyond the image: each pixel sees it.
TEST_F(GlDepthSourceTest, NoRaySlipsThroughBetweenTriangles) {
  for (uint64_t seed = 0; seed < 8; ++seed) {
    Dice dice(seed);
    MeshGeometry sheet;
    constexpr int kSide = 13;
    for (int j = 0; j <= kSide; ++j) {
      for (int i = 0; i <= kSide; ++i) {
        const auto place = [&](int k) {
          const float at = 2.0f * static_cast<float>(k) / kSide - 1;
          return (std::abs(at) < 1 ? at + dice.Between(-0.4f, 0.4f) / kSide : at) * 1000.0f *
                 std::pow(std::abs(at), 3.0f);
        };
        const float x = place(i), z = place(j);
        sheet.positions.emplace_back(x, -1 + 0.3f * x, z);
      }
    }
    for (int j = 0; j < kSide; ++j) {
      for (int i = 0; i < kSide; ++i) {
        const auto a = static_cast<uint32_t>(j * (kSide + 1) + i), c = a + kSide + 1;
        sheet.indices.insert(sheet.indices.end(), {a, a + 1, c, c, a + 1, c + 1});
      }
    }
    const auto scene = SceneOf({{.id = "sheet", .mesh = MeshOf(std::move(sheet))}});
    const std::array views{Down(0.9, 200, 200, dice.Between(0.001f, 0.3f), 500)};
    const DepthMap map = DrawByGl(*scene, views).at(0);
    for (uint32_t y = 0; y < 200; ++y) {
      for (uint32_t x = 0; x < 200; ++x) {
        const double expected = 1 / (1 + 0.3 * ((x + 0.5) / 200 * 1.8 - 0.9));
        EXPECT_NEAR(map.At(x, y) / expected, 1.0, 3e-4) << "seed " << seed << ' ' << x << ' ' << y;
      }
    }
  }
}

TEST_F(GlDepthSourceTest, ScalesFromAMicrometreToAThousandKilometres) {
  for (const float scale : {1e-6f, 1e-3f, 1e3f, 1e6f}) {
    const auto scene = SceneOf({{.id = "box",
                                 .mesh = MeshOf(UnitBoxGeometry()),
                                 .world_from_mesh = Placed({0, -4 * scale, 0}, scale)}});
    const std::array views{Down(0.5, 33, 33, 0.1 * scale, 5 * scale)};
    const DepthMap map = DrawByGl(*scene, views).at(0);
    EXPECT_NEAR(map.At(16, 16) / scale, 3.0, 1e-5) << scale;
    EXPECT_EQ(map.At(0, 0), kNoDepth) << scale;
  }
}

TEST_F(GlDepthSourceTest, AStopIsHeardAndErrorsArePassedOn) {
  const auto scene = RandomScene(2);
  GlDepthSource source(*scene, *context_, "a.method");
  const std::vector<LightView> views(16, SampledViews(*scene, 2, 16).at(0));
  std::stop_source stop;
  size_t taken = 0;
  auto status = source.Draw(views, stop.get_token(), [&](size_t, DepthMap) {
    if (++taken == 3) stop.request_stop();
    return absl::OkStatus();
  });
  EXPECT_EQ(status.code(), absl::StatusCode::kCancelled);
  EXPECT_EQ(taken, 3u);
  status = source.Draw(views, {}, [&](size_t index, DepthMap) {
    return index == 2 ? absl::DataLossError("enough") : absl::OkStatus();
  });
  EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss);
}

TEST_F(GlDepthSourceTest, MeshesAreUploadedOnceForAllViewsAndCalls) {
  const auto scene = SceneOf({{.id = "box", .mesh = MeshOf(UnitBoxGeometry())}});
  const std::array views{Down(0.5, 8, 8, 0.1, 5), Down(0.4, 9, 8, 0.1, 5)};
  (void)DrawByGl(*scene, views);
  (void)DrawByGl(*scene, views);
  EXPECT_EQ(MeshStore::Of(*context_).upload_count(), 1u);
}

TEST_F(GlDepthSourceTest, ViewsThatAreTooLargeAreRefusedByName) {
  const auto scene = RandomScene(1);
  GlDepthSource source(*scene, *context_, "a.method");
  const std::array views{Down(0.5, 20'000, 1, 0.1, 5)};
  const auto status = source.Draw(views, {}, [](size_t, DepthMap) { return absl::OkStatus(); });
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(ErrorFieldPath(status), "views[0].width");
}

TEST(LostContextTest, IsAnErrorNotACrash) {
  const auto scene = RandomScene(1);
  auto context = gl::Context::Create({.device = TestDevice()});
  ASSERT_TRUE(context.ok()) << context.status();
  GlDepthSource source(*scene, **context, "a.method");
  const auto views = SampledViews(*scene, 1, 16);
  const auto status = source.Draw(views, {}, [&](size_t, DepthMap) {
    (*context)->SimulateLoss();
    return absl::OkStatus();
  });
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
}

}  // namespace
}  // namespace penumbra::testing
