// Depth maps against the nearest of all triangles, found in double precision.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <iostream>
#include <vector>

#include "render/light_view/depth_raster.h"
#include "render/light_view/view_fit.h"
#include "render/scene/field_error.h"
#include "tests/support/random_scene.h"
#include "tests/support/shapes.h"
#include "tests/unit/light_view/depth_source_fixture.h"

namespace penumbra::testing {
namespace {

using DepthSourceTest = CpuDepthSourceTest;

TEST_P(DepthSourceTest, EveryPixelIsTheNearestTriangleInRandomScenes) {
  DepthComparison all;
  for (uint64_t seed = 0; seed < 48; ++seed) {
    const auto scene = RandomScene(seed);
    const auto triangles = OccluderTriangles(*scene);
    for (const DepthMap& map : DrawAll(*SourceOf(*scene), SampledViews(*scene, seed, 24))) {
      const DepthComparison one = CompareWithNearest(map, triangles);
      all.compared += one.compared;
      all.differing += one.differing;
      all.seen += one.seen;
      all.largest = std::max(all.largest, one.largest);
    }
  }
  std::cout << all.compared << " pixels, " << all.seen << " see something, " << all.differing
            << " differ; the others by " << all.largest << " at most\n";
  EXPECT_GT(all.compared, 20'000u);
  EXPECT_GT(all.seen, all.compared / 10);
  EXPECT_LT(all.seen, all.compared * 9 / 10);
  EXPECT_LE(all.differing, all.compared / 10'000);
}

bool HaveTheSameBits(const DepthMap& a, const DepthMap& b) { return a.depths == b.depths; }

TEST_P(DepthSourceTest, BitsDependNeitherOnThreadsNorOnCompany) {
  tbb::task_arena one_thread(1), many_threads(4);
  for (uint64_t seed = 0; seed < 6; ++seed) {
    const auto scene = RandomScene(seed);
    std::vector<LightView> views = SampledViews(*scene, seed, 150);
    const auto all = DrawAll(*SourceOf(*scene, many_threads), views);
    const auto one = SourceOf(*scene, one_thread);
    for (size_t i = views.size(); i-- > 0;) {
      const auto alone = DrawAll(*one, std::span(views).subspan(i, 1));
      EXPECT_TRUE(HaveTheSameBits(alone.at(0), all.at(i))) << "seed " << seed << " view " << i;
    }
  }
}

TEST_P(DepthSourceTest, BoxOnAFloorHasTheDepthsOfItsTop) {
  const auto box = MeshOf(UnitBoxGeometry());
  const auto square = MeshOf(UnitSquareGeometry());
  for (const float scale : {1e-6f, 1e-3f, 1.0f, 1e3f, 1e6f}) {
    SceneDelta delta;
    delta.upsert_instances = {
        {.id = "box",
         .mesh = box,
         .world_from_mesh = Placed(scale * Vec3(0, 0.5f, 0), 0.5f * scale)},
        {.id = "floor", .mesh = square, .world_from_mesh = Placed(Vec3(0), 2.0f * scale)},
        {.id = "ghost",
         .mesh = box,
         .world_from_mesh = Placed(scale * Vec3(0, 1.4f, 0), 0.2f * scale),
         .casts = false}};
    const RectangleLight lamp{.corner = scale * Vec3(-0.5f, 3, -0.5f),
                              .edge_u = scale * Vec3(1, 0, 0),
                              .edge_v = scale * Vec3(0, 0, 1)};
    delta.upsert_lights = {{.id = "lamp", .shape = lamp}};
    const auto scene = Scene::Empty("s")->Apply(delta).value();
    const auto faces = FacesOf(*scene->FindLight("lamp"), scene->Bounds());
    ASSERT_EQ(faces.size(), 1u);
    const auto view = CenterView(faces[0], CasterBoxes(*scene), 0.01);
    ASSERT_TRUE(view.has_value());
    const DepthMap map = DrawOne(*scene, *view);
    const auto depth_at = [&](DVec3 p) {
      const DVec3 at = view->Project(double{scale} * p);
      return map.At(static_cast<uint32_t>(at.x), static_cast<uint32_t>(at.y)) / scale;
    };
    EXPECT_NEAR(depth_at({0, 1, 0}), 2.0f, 1e-5f) << scale;
    EXPECT_NEAR(depth_at({1.5, 0, 1.5}), 3.0f, 1e-5f) << scale;
  }
}

TEST_P(DepthSourceTest, StopsWhenAsked) {
  const auto scene = RandomScene(1);
  const auto source = SourceOf(*scene);
  std::stop_source stop;
  stop.request_stop();
  const std::vector<LightView> views(1);
  const auto status =
      source->Draw(views, stop.get_token(), [](size_t, DepthMap) { return absl::OkStatus(); });
  EXPECT_EQ(status.code(), absl::StatusCode::kCancelled);
}

TEST_P(DepthSourceTest, StopsInTheMiddleAndPassesErrorsOn) {
  const auto scene = RandomScene(2);
  const auto source = SourceOf(*scene);
  const std::vector<LightView> views(16, SampledViews(*scene, 2, 16).at(0));
  std::stop_source stop;
  size_t taken = 0;
  auto status = source->Draw(views, stop.get_token(), [&](size_t, DepthMap) {
    if (++taken == 3) stop.request_stop();
    return absl::OkStatus();
  });
  EXPECT_EQ(status.code(), absl::StatusCode::kCancelled);
  EXPECT_EQ(taken, 3u);
  status = source->Draw(views, {}, [&](size_t index, DepthMap) {
    return index == 2 ? absl::DataLossError("enough") : absl::OkStatus();
  });
  EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss);
}

TEST_P(DepthSourceTest, ViewsThatAreTooLargeAreRefusedByName) {
  const auto scene = RandomScene(1);
  LightView view{.window = {.min = DVec2(-1), .max = DVec2(1)}, .width = 4, .height = 20'000};
  const std::array views{LightView{}, view};
  const auto status =
      SourceOf(*scene)->Draw(views, {}, [](size_t, DepthMap) { return absl::OkStatus(); });
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(ErrorReason(status), "VIEW_SIZE");
  EXPECT_EQ(ErrorFieldPath(status), "views[1].height");
  EXPECT_THAT(std::string(status.message()), ::testing::HasSubstr("need at most 16384"));
}

INSTANTIATE_TEST_SUITE_P(Cpu, DepthSourceTest, kCpuSources, SourceName);

TEST(DepthRasterTest, AStopIsObeyedWithinAMesh) {
  const auto scene = RandomScene(2);
  const LightView view = SampledViews(*scene, 2, 1).at(0);
  const RasterFrame frame{view.frame};
  std::stop_source stop;
  stop.request_stop();
  for (const auto& [id, instance] : scene->instances()) {
    EXPECT_EQ(PlacedCaster(frame, instance, stop.get_token()).cluster_count(), 0u);
    DepthRaster raster(view, frame);
    raster.Draw(PlacedCaster(frame, instance), stop.get_token());
    EXPECT_EQ(std::move(raster).Finish().depths, NothingSeen(view).depths);
  }
}

}  // namespace
}  // namespace penumbra::testing
