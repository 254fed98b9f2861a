// Views in which depth maps easily go wrong: from inside of things, with things at the light, far
// to the side, of nothing, of one pixel; and that no ray slips through between two triangles.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "render/light_view/view_fit.h"
#include "tests/support/random_scene.h"
#include "tests/support/shapes.h"
#include "tests/unit/light_view/depth_source_fixture.h"

namespace penumbra::testing {
namespace {

std::shared_ptr<const Scene> SceneOf(std::vector<Instance> instances) {
  SceneDelta delta;
  delta.upsert_instances = std::move(instances);
  return Scene::Empty("s")->Apply(delta).value();
}

// Straight down from the origin.
LightView Down(double slope, uint32_t side, double near, double far) {
  return {.frame = {.origin = DVec3(0), .axes = {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}}},
          .window = {.min = DVec2(-slope), .max = DVec2(slope)},
          .width = side,
          .height = side,
          .near = near,
          .far = far};
}

class HardViewsTest : public CpuDepthSourceTest {};

TEST_P(HardViewsTest, ALightInsideABoxSeesItsWalls) {
  const auto scene =
      SceneOf({{.id = "box", .mesh = MeshOf(UnitBoxGeometry()), .world_from_mesh = Placed({}, 3)}});
  const AreaLight light{.id = "l", .shape = PointLight{}};
  const auto faces = FacesOf(light, scene->Bounds());
  ASSERT_EQ(faces.size(), 6u);
  for (const LightFace& face : faces) {
    const auto view = CenterView(face, CasterBoxes(*scene), 0.05);
    ASSERT_TRUE(view.has_value());
    for (const float depth : DrawOne(*scene, *view).depths) EXPECT_NEAR(depth, 3.0f, 1e-5f);
  }
}

TEST_P(HardViewsTest, WhatLiesInTheLightsPlaneHidesNothingAndWhatIsCloseIsNotCut) {
  const auto square = MeshOf(UnitSquareGeometry());
  const RectangleLight lamp{.corner = {-0.2f, 0, 0.2f},
                            .edge_u = {0.4f, 0, 0},
                            .edge_v = {0, 0, -0.4f},
                            .two_sided = false};
  // The light's own surface; a sheet a millimetre before it; a floor ten metres away.
  const auto scene =
      SceneOf({{.id = "emitter", .mesh = square, .world_from_mesh = Placed({}, 0.2f)},
               {.id = "sheet", .mesh = square, .world_from_mesh = Placed({0, 0.001f, 0}, 0.0005f)},
               {.id = "floor", .mesh = square, .world_from_mesh = Placed({0, 10, 0}, 20.0f)}});
  const auto faces = FacesOf({.id = "lamp", .shape = lamp}, scene->Bounds());
  ASSERT_EQ(faces.size(), 5u) << "the emitter's edges are beside the light";
  const auto view = CenterView(faces[0], CasterBoxes(*scene), 0.01);
  ASSERT_TRUE(view.has_value());
  const DepthMap map = DrawOne(*scene, *view);
  // Half of the sheet's width is half its distance: it hides slopes up to ½.
  for (uint32_t y = 0; y < view->height; ++y) {
    for (uint32_t x = 0; x < view->width; ++x) {
      const DVec2 slope = view->window.min + (DVec2(x, y) + 0.5) / view->pixels_per_slope();
      const double widest = std::max(std::abs(slope.x), std::abs(slope.y));
      if (std::abs(widest - 0.5) < 1e-3) continue;
      EXPECT_NEAR(map.At(x, y) / (widest < 0.5 ? 0.001 : 10.0), 1.0, 1e-5) << x << ' ' << y;
    }
  }
}

// A plane in triangles of all sizes, cut where they reach too far and where they pass the eye: at
// each pixel there is one.
TEST_P(HardViewsTest, NoRaySlipsThroughBetweenTriangles) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    Dice dice(seed);
    const int side = 3 + static_cast<int>(dice.Below(30));
    MeshGeometry sheet;
    for (int j = 0; j <= side; ++j) {
      for (int i = 0; i <= side; ++i) {
        const auto place = [&](int k) {
          const float at = 2.0f * static_cast<float>(k) / static_cast<float>(side) - 1;
          return (std::abs(at) < 1 ? at + dice.Between(-0.4f, 0.4f) / side : at) * 1000.0f *
                 std::pow(std::abs(at), 3.0f);
        };
        const float x = place(i), z = place(j);
        sheet.positions.emplace_back(x, -1 + 0.3f * x, z);
      }
    }
    for (int j = 0; j < side; ++j) {
      for (int i = 0; i < side; ++i) {
        const auto a = static_cast<uint32_t>(j * (side + 1) + i), c = a + side + 1;
        sheet.indices.insert(sheet.indices.end(), {a, a + 1, c, c, a + 1, c + 1});
      }
    }
    const auto scene = SceneOf({{.id = "sheet", .mesh = MeshOf(std::move(sheet))}});
    const double near = dice.Between(0.001f, 0.3f);
    const DepthMap map = DrawOne(*scene, Down(0.9, 200, near, 500.0));
    for (uint32_t y = 0; y < 200; ++y) {
      for (uint32_t x = 0; x < 200; ++x) {
        // −z = −1 + 0.3 x z
        const double expected = 1 / (1 + 0.3 * ((x + 0.5) / 200 * 1.8 - 0.9));
        EXPECT_NEAR(map.At(x, y) / expected, 1.0, 3e-4) << "seed " << seed << ' ' << x << ' ' << y;
      }
    }
  }
}

TEST_P(HardViewsTest, ASmallSceneFarToTheSideIsAsSharp) {
  // A box of 2 cm ten metres away and fifteen to the side: pixels of a twentieth of a millimetre.
  const auto scene = SceneOf({{.id = "box",
                               .mesh = MeshOf(UnitBoxGeometry()),
                               .world_from_mesh = Placed({15, -10, 3}, 0.01f)}});
  LightView view = Down(1, 64, 1, 11);
  view.window = {.min = DVec2(1.4985, 0.2985), .max = DVec2(1.5015, 0.3015)};
  const DepthComparison result =
      CompareWithNearest(DrawOne(*scene, view), OccluderTriangles(*scene));
  EXPECT_GT(result.seen, 1'000u);
  EXPECT_LT(result.seen, 4'000u);
  EXPECT_EQ(result.differing, 0u);
}

TEST_P(HardViewsTest, ViewsOfNothingSeeNothing) {
  const auto box = SceneOf({{.id = "box", .mesh = MeshOf(UnitBoxGeometry())}});
  const auto empty = Scene::Empty("nothing");
  std::vector<LightView> views(3, Down(0.5, 8, 0.1, 10));
  views[0].width = 0;
  views[1].window.max = views[1].window.min;
  for (const auto& scene : {box, empty}) {
    const auto maps = DrawAll(*SourceOf(*scene), views);
    ASSERT_EQ(maps.size(), 3u);
    EXPECT_EQ(maps[0].depths.size(), 0u);
    ASSERT_EQ(maps[1].depths.size(), 64u);
    for (const float depth : maps[1].depths) EXPECT_EQ(depth, kNoDepth);
    const auto seen = std::ranges::count_if(maps[2].depths, [](float d) { return d != kNoDepth; });
    EXPECT_EQ(seen, scene == empty ? 0 : 64);
  }
}

TEST_P(HardViewsTest, OnePixelIsTheRayThroughItsMiddle) {
  const auto scene = SceneOf(
      {{.id = "box", .mesh = MeshOf(UnitBoxGeometry()), .world_from_mesh = Placed({0, -5, 0}, 1)}});
  EXPECT_NEAR(DrawOne(*scene, Down(1, 1, 0.1, 10)).depths.at(0), 4.0f, 1e-5f);
  LightView beside = Down(1, 1, 0.1, 10);
  beside.window = {.min = DVec2(0), .max = DVec2(1)};  // its middle passes the box
  EXPECT_EQ(DrawOne(*scene, beside).depths.at(0), kNoDepth);
}

TEST_P(HardViewsTest, TrianglesOfNoAreaAreNotSeenAndMakeNoNan) {
  const Affine flat(Vec3(1, 0, 0), Vec3(0), Vec3(0, 0, 1), Vec3(0, -4, 0));
  const Affine line(Vec3(1, 1, 1), Vec3(0), Vec3(0), Vec3(0, -3, 0));
  const auto box = MeshOf(UnitBoxGeometry());
  const auto scene =
      SceneOf({{.id = "flat", .mesh = box, .world_from_mesh = flat},
               {.id = "line", .mesh = box, .world_from_mesh = line},
               {.id = "point", .mesh = box, .world_from_mesh = Placed({0, -2, 0}, 0.0f)}});
  for (const double near : {0.01, 3.999}) {
    size_t seen = 0;
    for (const float depth : DrawOne(*scene, Down(0.5, 64, near, 10)).depths) {
      ASSERT_FALSE(std::isnan(depth));
      if (depth == kNoDepth) continue;
      EXPECT_NEAR(depth, 4.0f, 1e-5f);
      ++seen;
    }
    EXPECT_EQ(seen, 32u * 32u);
  }
}

INSTANTIATE_TEST_SUITE_P(Cpu, HardViewsTest, kCpuSources, SourceName);

}  // namespace
}  // namespace penumbra::testing
