// Drawing triangles by every instruction set of this machine.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "hwy/targets.h"
#include "render/light_view/raster_depth_source.h"
#include "render/light_view/view_fit.h"
#include "tests/support/drawn_views.h"
#include "tests/support/nearest_depth.h"
#include "tests/support/random_scene.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

class RasterTargetsTest : public ::testing::TestWithParam<int64_t> {
 protected:
  void SetUp() override { hwy::SetSupportedTargetsForTest(GetParam()); }
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }

  std::vector<DepthMap> Draw(const Scene& scene, const std::vector<LightView>& views) {
    RasterDepthSource source(scene, arena_);
    return DrawAll(source, views);
  }

  tbb::task_arena arena_{1};
};

TEST_P(RasterTargetsTest, EveryPixelIsTheNearestTriangleInRandomScenes) {
  size_t compared = 0, seen = 0, differing = 0;
  for (uint64_t seed = 0; seed < 12; ++seed) {
    const auto scene = RandomScene(seed);
    const auto light = scene->FindLight("light");
    const auto boxes = CasterBoxes(*scene);
    std::vector<LightView> views;
    for (const LightFace& face : FacesOf(*light, scene->Bounds())) {
      const double pitch = std::max(face.window.size().x, face.window.size().y) / 24;
      if (const auto view = CenterView(face, boxes, pitch)) views.push_back(*view);
    }
    const auto triangles = OccluderTriangles(*scene);
    for (const DepthMap& map : Draw(*scene, views)) {
      const DepthComparison one = CompareWithNearest(map, triangles);
      compared += one.compared;
      seen += one.seen;
      differing += one.differing;
    }
  }
  EXPECT_GT(seen, 2'000u);
  EXPECT_LE(differing, compared / 10'000);
}

// Many small triangles and a few large ones side by side: no pixel of the sheet is left out.
TEST_P(RasterTargetsTest, NoRaySlipsThroughBetweenTriangles) {
  Dice dice(7);
  constexpr int kSide = 90;
  MeshGeometry sheet;
  for (int j = 0; j <= kSide; ++j) {
    for (int i = 0; i <= kSide; ++i) {
      const auto place = [&](int k) {
        const float at = 2.0f * static_cast<float>(k) / kSide - 1;
        const float moved = std::abs(at) < 1 ? at + dice.Between(-0.4f, 0.4f) / kSide : at;
        return 2 * moved * std::abs(moved);
      };
      const float x = place(i), z = place(j);
      sheet.positions.emplace_back(x, -1, z);
    }
  }
  for (int j = 0; j < kSide; ++j) {
    for (int i = 0; i < kSide; ++i) {
      const auto a = static_cast<uint32_t>(j * (kSide + 1) + i), c = a + kSide + 1;
      sheet.indices.insert(sheet.indices.end(), {a, a + 1, c, c, a + 1, c + 1});
    }
  }
  SceneDelta delta;
  delta.upsert_instances = {{.id = "sheet", .mesh = MeshOf(std::move(sheet))}};
  const auto scene = Scene::Empty("s")->Apply(delta).value();
  const LightView down{.frame = {.origin = DVec3(0), .axes = {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}}},
                       .window = {.min = DVec2(-0.9), .max = DVec2(0.9)},
                       .width = 300,
                       .height = 280,
                       .near = 0.5,
                       .far = 2};
  const DepthMap map = Draw(*scene, {down}).at(0);
  for (const float depth : map.depths) ASSERT_NEAR(depth, 1.0f, 1e-6f);
}

INSTANTIATE_TEST_SUITE_P(Targets, RasterTargetsTest,
                         ::testing::ValuesIn(hwy::SupportedAndGeneratedTargets()),
                         [](const auto& target) {
                           return std::string(hwy::TargetName(target.param));
                         });

}  // namespace
}  // namespace penumbra::testing
