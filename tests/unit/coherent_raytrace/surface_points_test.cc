// Where shadows are computed.
#include "render/technique/coherent_raytrace/surface_points.h"

#include <gtest/gtest.h>

#include <cmath>

#include "render/scene/field_error.h"
#include "tests/support/shapes.h"

namespace penumbra {
namespace {

std::shared_ptr<const Scene> BoxOnAFloor() {
  SceneDelta delta;
  delta.upsert_instances = {{.id = "box",
                             .mesh = testing::MeshOf(testing::UnitBoxGeometry()),
                             .world_from_mesh = testing::Placed(Vec3(0, 0.5f, 0), 0.5f)},
                            // It casts nothing, and is seen all the same.
                            {.id = "floor",
                             .mesh = testing::MeshOf(testing::UnitSquareGeometry()),
                             .world_from_mesh = testing::Placed(Vec3(0), 2.0f),
                             .casts = false}};
  return Scene::Empty("s")->Apply(delta).value();
}

class VisiblePointsTest : public ::testing::Test {
 protected:
  absl::StatusOr<SurfacePoints> See(const Camera& camera, uint32_t width, uint32_t height,
                                    const PixelRect& crop) {
    const auto scene = BoxOnAFloor();
    return VisiblePoints(*bvhs_.Of(*scene, CasterBvhs::Instances::kAll), camera, width, height,
                         crop, arena_);
  }
  CasterBvhs bvhs_;
  tbb::task_arena arena_{2};
  const Camera camera_{.eye = {2, 3, 4}, .target = {0, 0.5f, 0}, .fov_y_deg = 50};
};

TEST_F(VisiblePointsTest, ProjectBackToTheirPixels) {
  const auto points = See(camera_, 60, 40, {0, 0, 60, 40});
  ASSERT_TRUE(points.ok()) << points.status();
  const DMat4 clip = ClipFromWorld(camera_, 1.5);
  size_t on_floor = 0, on_box = 0;
  for (size_t i = 0; i < points->size(); ++i) {
    if (!points->is_there[i]) continue;
    const auto& [p, n] = points->points[i];
    const DVec4 at = clip * DVec4(DVec3(p), 1);
    EXPECT_NEAR((at.x / at.w + 1) * 30, i % 60 + 0.5, 1e-3);
    EXPECT_NEAR((1 - at.y / at.w) * 20, i / 60 + 0.5, 1e-3);
    EXPECT_GT(glm::dot(n, camera_.eye - p), 0);
    EXPECT_NEAR(glm::length(n), 1, 1e-6);
    on_floor += std::abs(p.y) < 1e-5 && n == Vec3(0, 1, 0);
    on_box += std::abs(std::max({std::abs(p.x), std::abs(p.y - 0.5f), std::abs(p.z)}) - 0.5) < 1e-5;
  }
  EXPECT_GT(on_floor, 300u);
  EXPECT_GT(on_box, 50u);
}

TEST_F(VisiblePointsTest, ACropIsThatPartOfThePicture) {
  const auto whole = See(camera_, 60, 40, {0, 0, 60, 40});
  const auto part = See(camera_, 60, 40, {13, 7, 21, 18});
  ASSERT_TRUE(whole.ok() && part.ok());
  for (uint32_t y = 0; y < 18; ++y) {
    for (uint32_t x = 0; x < 21; ++x) {
      const size_t i = (y + 7) * 60 + x + 13, k = y * 21 + x;
      ASSERT_EQ(part->is_there[k], whole->is_there[i]);
      EXPECT_LT(glm::distance(part->points[k].position, whole->points[i].position), 1e-5f);
    }
  }
}

TEST_F(VisiblePointsTest, LookingAtNothingOrFromInsideIsNoError) {
  const Camera away{.eye = {0, 5, 0}, .target = {0, 9, 0}};
  const auto nothing = See(away, 16, 16, {0, 0, 16, 16});
  ASSERT_TRUE(nothing.ok());
  EXPECT_EQ(std::count(nothing->is_there.begin(), nothing->is_there.end(), 1), 0);
  EXPECT_EQ(SpacingOf(*nothing), 0.0f);
  const Camera inside{.eye = {0, 0.5f, 0}, .target = {1, 0.5f, 0}};
  const auto walls = See(inside, 16, 16, {0, 0, 16, 16});
  ASSERT_TRUE(walls.ok());
  EXPECT_EQ(std::count(walls->is_there.begin(), walls->is_there.end(), 1), 256);
}

TEST_F(VisiblePointsTest, RefusesWhatIsNoPicture) {
  EXPECT_EQ(See(camera_, 0, 4, {0, 0, 1, 1}).status().message(), "width: found 0, need 1 to 16384");
  EXPECT_EQ(See(camera_, 60, 40, {50, 0, 11, 1}).status().message(),
            "crop: found 11 x 1 at (50, 0), need a part of 60 x 40");
  EXPECT_EQ(ErrorFieldPath(See({.eye = {NAN, 0, 0}}, 4, 4, {0, 0, 4, 4}).status()), "camera.eye");
}

TEST(ListedPointsTest, AreNormalizedOrNamed) {
  const std::vector<SurfacePoint> points = {{{1, 2, 3}, {0, 0, 4}}, {{0, 0, 0}, {0, 1e-20f, 0}}};
  const auto listed = ListedPoints(points);
  ASSERT_TRUE(listed.ok()) << listed.status();
  EXPECT_EQ(listed->width, 2u);
  EXPECT_EQ(listed->points[0].normal, Vec3(0, 0, 1));
  EXPECT_EQ(listed->points[1].normal, Vec3(0, 1, 0));
  const auto message = [](SurfacePoint bad) {
    return std::string(ListedPoints(std::vector{SurfacePoint{}, bad}).status().message());
  };
  EXPECT_EQ(message({Vec3(0), Vec3(0)}), "points[1].normal: found length 0, need > 0");
  EXPECT_EQ(message({Vec3(INFINITY), Vec3(0, 1, 0)}), "points[1].position: need finite numbers");
  EXPECT_EQ(message({Vec3(0), Vec3(0, NAN, 0)}), "points[1].normal: need finite numbers");
  EXPECT_EQ(ListedPoints({})->size(), 0u);
}

TEST(LightmapPointsTest, TexelsLieWhereTheirUvSays) {
  const Instance floor{.id = "floor",
                       .mesh = testing::MeshOf(testing::UnitSquareGeometry()),
                       .world_from_mesh = testing::Placed(Vec3(1, 2, 3), 2.0f)};
  const auto points = LightmapPoints(floor, 8, 4);
  ASSERT_TRUE(points.ok()) << points.status();
  for (uint32_t y = 0; y < 4; ++y) {
    for (uint32_t x = 0; x < 8; ++x) {
      const size_t i = y * 8 + x;
      ASSERT_TRUE(points->is_there[i]);
      // uv (0, 0) is at (−1, 0, 1), (1, 1) at (1, 0, −1).
      const Vec3 expected(1 + 2 * ((x + 0.5f) / 4 - 1), 2, 3 + 2 * (1 - (y + 0.5f) / 2));
      EXPECT_LT(glm::distance(points->points[i].position, expected), 1e-5f);
      EXPECT_EQ(points->points[i].normal, Vec3(0, 1, 0));
    }
  }
  const Instance bare{.id = "bare", .mesh = testing::MeshOf(testing::UnitBoxGeometry())};
  EXPECT_EQ(LightmapPoints(bare, 8, 8).status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(ErrorFieldPath(LightmapPoints(floor, 8, 0).status()), "height");
}

}  // namespace
}  // namespace penumbra
