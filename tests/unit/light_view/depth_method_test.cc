#include "render/light_view/depth_method.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "render/light_view/auto_depth_source.h"
#include "render/light_view/make_depth_source.h"
#include "render/scene/field_error.h"
#include "tests/support/drawn_views.h"
#include "tests/support/rippled_torus.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

// Straight down from 4 m above a scene of 2 m, which fills the image.
LightView Down(uint32_t side) {
  return {.frame = {.origin = DVec3(0, 4, 0), .axes = {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}}},
          .window = {.min = DVec2(-0.5), .max = DVec2(0.5)},
          .width = side,
          .height = side,
          .near = 1,
          .far = 5};
}

std::shared_ptr<const Scene> SceneOf(std::vector<Instance> instances) {
  SceneDelta delta;
  delta.upsert_instances = std::move(instances);
  return Scene::Empty("s")->Apply(delta).value();
}

Instance BoxAt(std::string id, Vec3 place) {
  return {.id = std::move(id),
          .mesh = MeshOf(UnitBoxGeometry()),
          .world_from_mesh = Placed(place, 1.0f)};
}

TEST(DepthMethodTest, CountsWhatAViewMaySee) {
  Instance masked = BoxAt("masked", Vec3(0));
  masked.mesh = MeshOf(UnitSquareGeometry());
  masked.alpha_mask = AlphaMask::Create(1, 1, {255}).value();
  Instance ghost = BoxAt("ghost", Vec3(0));
  ghost.casts = false;
  const auto scene = SceneOf({BoxAt("box", Vec3(0)), BoxAt("behind", Vec3(0, 20, 0)),
                              BoxAt("beside", Vec3(90, 0, 0)), masked, ghost});
  const DepthWork work = CasterSizes(*scene).WorkOf(Down(100));
  EXPECT_EQ(work.pixels, 10'000);
  EXPECT_EQ(work.casters, 2);
  EXPECT_EQ(work.triangles, 12);
  EXPECT_EQ(work.masked_triangles, 2);
  // Two metres at a distance of 3 and of 4, on an image of one slope.
  EXPECT_NEAR(work.covered, 1e4 * (4.0 / 9 + 4.0 / 16), 1);
  // 24 and 4 m², of which half is seen, at 4 m.
  EXPECT_NEAR(work.filled, 1e4 * 12.0 / 16, 1);
  EXPECT_NEAR(work.masked_filled, 1e4 * 2.0 / 16, 1);
  EXPECT_EQ(CasterSizes(*scene).WorkOf(LightView{}).triangles, 0);
}

TEST(DepthMethodTest, FewTrianglesAreDrawnAndManyOnFewPixelsMetByRays) {
  const auto few = SceneOf({BoxAt("box", Vec3(0))});
  const auto many = SceneOf({{.id = "torus", .mesh = MeshOf(RippledTorus(1000, 250))}});
  EXPECT_LT(RasterNs(CasterSizes(*few).WorkOf(Down(512))),
            RaysNs(CasterSizes(*few).WorkOf(Down(512))));
  EXPECT_GT(RasterNs(CasterSizes(*many).WorkOf(Down(64))),
            RaysNs(CasterSizes(*many).WorkOf(Down(64))));
  EXPECT_LT(RasterNs(CasterSizes(*many).WorkOf(Down(4096))),
            RaysNs(CasterSizes(*many).WorkOf(Down(4096))));
}

TEST(AutoDepthSourceTest, DrawsEachViewTheCheaperWay) {
  const auto scene = SceneOf({{.id = "torus", .mesh = MeshOf(RippledTorus(500, 100))}});
  tbb::task_arena arena(2);
  CasterBvhs bvhs;
  AutoDepthSource source(*scene, bvhs, arena);
  RasterDepthSource raster(*scene, arena);
  RayDepthSource rays(bvhs.Of(*scene), arena);
  const std::array views{Down(16), Down(900), Down(32), Down(24)};
  std::vector<DepthMap> maps;
  const auto keep = [&](std::vector<DepthMap>& into) {
    return [&into](size_t index, DepthMap map) {
      EXPECT_EQ(index, into.size());
      into.push_back(std::move(map));
      return absl::OkStatus();
    };
  };
  ASSERT_TRUE(source.Draw(views, {}, keep(maps)).ok());
  ASSERT_EQ(maps.size(), views.size());
  size_t by_rays = 0;
  for (size_t i = 0; i < views.size(); ++i) {
    const bool is_rays = !source.IsDrawn(views[i]);
    by_rays += is_rays;
    std::vector<DepthMap> expected;
    DepthSource& one = is_rays ? static_cast<DepthSource&>(rays) : raster;
    ASSERT_TRUE(one.Draw(std::span(&views[i], 1), {}, keep(expected)).ok());
    EXPECT_EQ(maps[i].depths, expected.at(0).depths) << i;
  }
  EXPECT_EQ(by_rays, 3u);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(source.Draw(views, stop.get_token(), keep(maps)).code(), absl::StatusCode::kCancelled);
}

// A model over a wide floor: rays around the model, as many as its box has pixels, and the floor
// drawn beside it. It slopes, so that its depths by rays are rounded otherwise on every machine.
TEST(SplitDepthSourceTest, TracesWhereMoreThanAFewTrianglesMayBeSeen) {
  Instance floor{.id = "floor", .mesh = MeshOf(UnitSquareGeometry())};
  const Vec3 along(7.9f, 1.3f, 0.4f), across(-0.3f, 0.2f, 8.0f);
  floor.world_from_mesh = Affine(along, glm::cross(across, along) / 8.0f, across, Vec3(0, -2, 0));
  const auto scene =
      SceneOf({{.id = "torus", .mesh = MeshOf(RippledTorus(500, 100))}, std::move(floor)});
  tbb::task_arena arena(2);
  CasterBvhs bvhs;
  const LightView view = Down(200);
  SplitDepthSource split(*scene, bvhs, arena);
  AutoDepthSource automatic(*scene, bvhs, arena);
  RasterDepthSource raster(*scene, arena);
  RayDepthSource rays(bvhs.Of(*scene), arena);
  const auto draw = [&](DepthSource& source) { return DrawAll(source, std::span(&view, 1)).at(0); };
  const DepthMap of_both = draw(split), drawn = draw(raster), traced = draw(rays);
  EXPECT_EQ(split.drawn_by(), "raster and rays");
  size_t as_traced = 0, as_drawn_alone = 0;
  for (size_t i = 0; i < of_both.depths.size(); ++i) {
    const bool is_traced = of_both.depths[i] == traced.depths[i];
    as_traced += is_traced;
    as_drawn_alone += !is_traced && of_both.depths[i] == drawn.depths[i];
    EXPECT_TRUE(is_traced || of_both.depths[i] == drawn.depths[i]) << i;
  }
  EXPECT_GT(as_traced, 1000u);
  EXPECT_GT(as_drawn_alone, 100u);
  EXPECT_LT(split.CostNs(view), RaysNs(CasterSizes(*scene).WorkOf(view)));
  EXPECT_EQ(draw(automatic).depths, automatic.IsDrawn(view) ? drawn.depths : of_both.depths);
}

TEST(MakeDepthSourceTest, MakesWhatIsAskedForOrNamesTheField) {
  const auto scene = SceneOf({BoxAt("box", Vec3(0))});
  tbb::task_arena arena(1);
  CasterBvhs bvhs;
  const DepthSourceMeans means{.bvhs = bvhs, .arena = arena, .gl_error = "no display"};
  const auto make = [&](DepthMethod method) {
    return MakeDepthSource(method, *scene, means, "a.depth_method");
  };
  EXPECT_NE(dynamic_cast<AutoDepthSource*>(make(DepthMethod::kAuto)->get()), nullptr);
  EXPECT_NE(dynamic_cast<RasterDepthSource*>(make(DepthMethod::kRaster)->get()), nullptr);
  EXPECT_NE(dynamic_cast<RayDepthSource*>(make(DepthMethod::kRays)->get()), nullptr);
  const absl::Status refused = make(DepthMethod::kGl).status();
  EXPECT_EQ(refused.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(ErrorReason(refused), "NO_GL");
  EXPECT_EQ(ErrorFieldPath(refused), "a.depth_method");
  EXPECT_THAT(std::string(refused.message()), ::testing::HasSubstr("another method: no display"));
}

TEST(DepthMethodTest, HasItsNames) {
  EXPECT_EQ(NameOf(DepthMethod::kAuto), "auto");
  EXPECT_EQ(NameOf(DepthMethod::kRaster), "raster");
  EXPECT_EQ(NameOf(DepthMethod::kRays), "rays");
  EXPECT_EQ(NameOf(DepthMethod::kGl), "gl");
}

}  // namespace
}  // namespace penumbra::testing
