#include "client/cli/scene_edit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/shapes.h"

namespace penumbra {
namespace {

TEST(MoveAnObjectTest, TakesTheLargestThatIsNoRoomAndNoGround) {
  const auto box = testing::MeshOf(testing::UnitBoxGeometry());
  const auto square = testing::MeshOf(testing::UnitSquareGeometry());
  SceneDelta content;
  content.upsert_instances = {
      {.id = "room", .mesh = box, .world_from_mesh = testing::Placed(Vec3(0), 10.0f)},
      {.id = "ground", .mesh = square, .world_from_mesh = testing::Placed(Vec3(0), 10.0f)},
      {.id = "large", .mesh = box, .world_from_mesh = testing::Placed(Vec3(1, 1, 1), 1.5f)},
      {.id = "small", .mesh = box, .world_from_mesh = testing::Placed(Vec3(4, 1, 1), 0.5f)}};
  const auto scene = *Scene::Empty("s")->Apply(content);
  const auto delta = MoveAnObject(*scene);
  ASSERT_TRUE(delta.ok()) << delta.status();
  ASSERT_EQ(delta->upsert_instances.size(), 1u);
  EXPECT_EQ(delta->upsert_instances[0].id, "large");
  EXPECT_EQ(delta->upsert_instances[0].world_from_mesh[3], Vec3(2, 1, 1));
}

TEST(MoveAnObjectTest, AnEmptySceneHasNone) {
  EXPECT_EQ(MoveAnObject(*Scene::Empty("s")).status().code(),
            absl::StatusCode::kFailedPrecondition);
}

TEST(MoveTheLampTest, TheBrightestMovesWithWhatGlows) {
  SceneDelta delta;
  delta.upsert_lights = {{.id = "candle", .shape = SphereLight{.radius = 0.01f}},
                         {.id = "softbox", .shape = RectangleLight{.radiance = Vec3(5.0f)}}};
  delta.upsert_instances = {
      {.id = "softbox", .mesh = testing::MeshOf(testing::UnitSquareGeometry()), .casts = false},
      {.id = "table", .mesh = testing::MeshOf(testing::UnitBoxGeometry())}};
  const auto scene = Scene::Empty("s")->Apply(delta).value();
  const auto moved = MoveTheLamp(*scene);
  ASSERT_TRUE(moved.ok());
  ASSERT_EQ(moved->upsert_lights.size(), 1u);
  EXPECT_EQ(moved->upsert_lights[0].id, "softbox");
  ASSERT_EQ(moved->upsert_instances.size(), 1u);
  const Vec3 by = std::get<RectangleLight>(moved->upsert_lights[0].shape).corner;
  EXPECT_GT(glm::length(by), 0.0f);
  EXPECT_EQ(moved->upsert_instances[0].world_from_mesh[3], by);
}

TEST(MoveTheLampTest, EveryKindMovesAndNothingElseChanges) {
  for (const LightShape& shape :
       {LightShape(RectangleLight{}), LightShape(DiskLight{}), LightShape(SphereLight{}),
        LightShape(PointLight{}), LightShape(SpotLight{}), LightShape(DistantLight{})}) {
    SceneDelta content;
    content.upsert_lights = {{.id = "lamp", .shape = shape}};
    const auto scene = *Scene::Empty("s")->Apply(content);
    const auto delta = MoveTheLamp(*scene);
    ASSERT_TRUE(delta.ok()) << delta.status();
    ASSERT_EQ(delta->upsert_lights.size(), 1u);
    EXPECT_EQ(delta->upsert_lights[0].id, "lamp");
    EXPECT_EQ(delta->upsert_lights[0].shape.index(), shape.index());
    EXPECT_FALSE(delta->upsert_lights[0] == *scene->FindLight("lamp"));
    EXPECT_TRUE(scene->Apply(*delta).ok());
  }
  EXPECT_FALSE(MoveTheLamp(*Scene::Empty("s")).ok());
}

}  // namespace
}  // namespace penumbra
