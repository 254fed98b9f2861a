// Where shadows are computed.
#include "render/technique/coherent_raytrace/surface_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

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
                                    const PixelRect& crop = {}, const std::stop_token& stop = {}) {
    const auto scene = BoxOnAFloor();
    return VisiblePoints(*bvhs_.Of(*scene, CasterBvhs::Instances::kAll),
                         {.camera = camera, .width = width, .height = height, .crop = crop}, arena_,
                         stop);
  }
  CasterBvhs bvhs_;
  tbb::task_arena arena_{2};
  const Camera camera_{.eye = {2, 3, 4}, .target = {0, 0.5f, 0}, .fov_y_deg = 50};
};

TEST_F(VisiblePointsTest, ProjectBackToTheirPixels) {
  const auto points = See(camera_, 60, 40);
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
  const auto whole = See(camera_, 60, 40);
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
  const auto nothing = See(away, 16, 16);
  ASSERT_TRUE(nothing.ok());
  EXPECT_EQ(std::count(nothing->is_there.begin(), nothing->is_there.end(), 1), 0);
  EXPECT_EQ(SpacingOf(*nothing), 0.0f);
  const Camera inside{.eye = {0, 0.5f, 0}, .target = {1, 0.5f, 0}};
  const auto walls = See(inside, 16, 16);
  ASSERT_TRUE(walls.ok());
  EXPECT_EQ(std::count(walls->is_there.begin(), walls->is_there.end(), 1), 256);
}

// Of a picture that is larger than any that is computed in one piece.
TEST_F(VisiblePointsTest, ADeepZoomIsAPartOfAVeryLargePicture) {
  constexpr uint32_t kSide = 1u << 20;
  const PixelRect crop{.x = kSide / 2 - 8, .y = kSide / 2 - 4, .width = 16, .height = 8};
  const PointReceiver picture =
      PicturePixels{.camera = camera_, .width = kSide, .height = kSide, .crop = crop};
  ASSERT_TRUE(Check(picture).ok());
  const auto points = See(camera_, kSide, kSide, crop);
  ASSERT_TRUE(points.ok()) << points.status();
  EXPECT_EQ(points->size(), 128u);
  // All about where the camera looks at, on the box.
  const Vec3 way = glm::normalize(camera_.target - camera_.eye);
  for (size_t i = 0; i < points->size(); ++i) {
    ASSERT_TRUE(points->is_there[i]);
    EXPECT_GT(glm::dot(glm::normalize(points->points[i].position - camera_.eye), way), 1 - 1e-6f);
  }
}

TEST_F(VisiblePointsTest, StopsWhenAsked) {
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(See(camera_, 60, 40, {}, stop.get_token()).status().code(),
            absl::StatusCode::kCancelled);
}

TEST(ListedPointsTest, AreNormalized) {
  const SurfacePoints listed = ListedPoints({std::make_shared<const std::vector<SurfacePoint>>(
      std::vector<SurfacePoint>{{{1, 2, 3}, {0, 0, 4}}, {{0, 0, 0}, {0, 1e-20f, 0}}})});
  EXPECT_EQ(listed.width, 2u);
  EXPECT_EQ(listed.height, 1u);
  EXPECT_EQ(listed.points[0].position, Vec3(1, 2, 3));
  EXPECT_EQ(listed.points[0].normal, Vec3(0, 0, 1));
  EXPECT_EQ(listed.points[1].normal, Vec3(0, 1, 0));
}

TEST(LightmapPointsTest, TexelsLieWhereTheirUvSays) {
  const Instance floor{.id = "floor",
                       .mesh = testing::MeshOf(testing::UnitSquareGeometry()),
                       .world_from_mesh = testing::Placed(Vec3(1, 2, 3), 2.0f)};
  const auto points = LightmapPoints(floor, {"floor", 8, 4});
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
}

// Texel coordinates beyond what an integer holds, on either side of the map.
TEST(LightmapPointsTest, TrianglesFarOutsideOfTheMapCoverNothing) {
  for (const float far : {-9e8f, 9e8f}) {
    MeshGeometry geometry = testing::UnitSquareGeometry();
    for (Vec2& uv : geometry.uvs) uv = 0.5f * uv + Vec2(far);
    const Instance floor{.id = "floor", .mesh = testing::MeshOf(std::move(geometry))};
    const auto points = LightmapPoints(floor, {"floor", 64, 64});
    ASSERT_TRUE(points.ok()) << points.status();
    EXPECT_EQ(std::ranges::count(points->is_there, 1), 0) << far;
  }
}

TEST(LightmapPointsTest, StopsWhenAsked) {
  const Instance floor{.id = "floor", .mesh = testing::MeshOf(testing::UnitSquareGeometry())};
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(LightmapPoints(floor, {"floor", 8, 4}, stop.get_token()).status().code(),
            absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace penumbra
