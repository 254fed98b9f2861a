#include "client/cli/shadow_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/scene/unoccluded_light.h"
#include "tests/support/shapes.h"

namespace penumbra {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

ImportedScene Room() {
  ImportedScene imported;
  const auto box = testing::MeshOf(testing::UnitBoxGeometry());
  const auto square = testing::MeshOf(testing::UnitSquareGeometry());
  imported.instances = {
      {.id = "box", .mesh = box, .world_from_mesh = testing::Placed(Vec3(1, 2, 3), 0.5f)},
      {.id = "small", .mesh = square, .world_from_mesh = testing::Placed(Vec3(1, 2, 3), 0.1f)},
      {.id = "large", .mesh = square, .world_from_mesh = testing::Placed(Vec3(1, 2, 3), 0.4f)}};
  imported.lights = {{.id = "lamp", .shape = SphereLight{.center = {0, 5, 0}}},
                     {.id = "sun", .shape = DistantLight{}}};
  return imported;
}

TEST(FloorUnderTest, LiesAtTheBottomThreeTimesAsWideFrontUpRowZeroAtLargestZ) {
  const Parallelogram floor = FloorUnder({.min = {-1, 2, -5}, .max = {3, 9, 1}});
  EXPECT_EQ(floor.edge_u, Vec3(12, 0, 0));
  EXPECT_EQ(floor.edge_v, Vec3(0, 0, -18));
  EXPECT_EQ(floor.origin, Vec3(1 - 6, 2, -2 + 9));
  EXPECT_EQ(floor.At({0.5f, 0.5f}), Vec3(1, 2, -2));
  EXPECT_EQ(floor.normal(), Vec3(0, 1, 0));
}

TEST(FloorUnderTest, ScenesWithoutWidthGetOneToo) {
  const Parallelogram wall = FloorUnder({.min = {0, 0, 0}, .max = {2, 1, 0}});
  EXPECT_EQ(wall.edge_u, Vec3(6, 0, 0));
  EXPECT_EQ(wall.edge_v, Vec3(0, 0, -6));
  EXPECT_EQ(FloorUnder({.min = Vec3(4), .max = Vec3(4)}).edge_u, Vec3(3, 0, 0));
  EXPECT_EQ(FloorUnder({}).edge_u, Vec3(3, 0, 0));
}

TEST(LightAboveTest, MakesTheMiddleOfAWhiteFloorReflectOne) {
  for (const Aabb box : {Aabb{.min = {-1, 0, -2}, .max = {1, 4, 2}},
                         Aabb{.min = {10, 10, 10}, .max = {10.2f, 10.1f, 10.3f}}, Aabb{}}) {
    const AreaLight light = LightAbove(box);
    const Vec3 center = box.empty() ? Vec3(0) : box.center();
    const float bottom = box.empty() ? -0.5f : box.min.y;
    const Vec3 reflected =
        UnoccludedRadiance(light, Vec3(center.x, bottom, center.z), Vec3(0, 1, 0));
    EXPECT_NEAR(reflected.x, 1.0f, 1e-4f);
    const auto& rectangle = std::get<RectangleLight>(light.shape);
    EXPECT_GT(rectangle.corner.y, box.empty() ? 0.5f : box.max.y);
    EXPECT_LT(glm::cross(rectangle.edge_u, rectangle.edge_v).y, 0.0f) << "shines up";
  }
}

TEST(PlanShadowsTest, AllLightsOfTheFileUnlessSomeAreNamed) {
  ShadowRequest request{.floor = true};
  auto plan = PlanShadows(Room(), request);
  ASSERT_TRUE(plan.ok()) << plan.status();
  EXPECT_THAT(plan->light_ids, ElementsAre("lamp", "sun"));
  EXPECT_THAT(plan->receiver_ids, ElementsAre("floor"));
  EXPECT_EQ(plan->delta.upsert_instances.size(), 3u);

  request.light_ids = {"sun"};
  request.lights = {{.id = "sun", .shape = PointLight{}}};
  plan = PlanShadows(Room(), request);
  ASSERT_TRUE(plan.ok());
  EXPECT_THAT(plan->light_ids, ElementsAre("sun", "sun-2"));
  EXPECT_EQ(plan->delta.upsert_lights.size(), 2u);
}

TEST(PlanShadowsTest, ASceneWithoutLightsGetsOneAndIsToldSo) {
  ImportedScene dark = Room();
  dark.lights.clear();
  const auto plan = PlanShadows(dark, {.floor = true});
  ASSERT_TRUE(plan.ok());
  EXPECT_THAT(plan->light_ids, ElementsAre("above"));
  EXPECT_THAT(plan->notes, ElementsAre(HasSubstr("no lights")));
}

TEST(PlanShadowsTest, ReceiversHaveNamesOfTheirOwnAndTheSizesAskedFor) {
  const ShadowRequest request{.receivers = {Parallelogram{}, Parallelogram{}},
                              .receiver_instances = {"small"},
                              .floor = true,
                              .texels = GridSize{32, 16},
                              .reflectance = Vec3(0.5f)};
  const auto plan = PlanShadows(Room(), request);
  ASSERT_TRUE(plan.ok());
  EXPECT_THAT(plan->receiver_ids, ElementsAre("floor", "receiver", "receiver-2", "small"));
  for (const Receiver& receiver : plan->delta.upsert_receivers) {
    EXPECT_EQ(receiver.width, 32u);
    EXPECT_EQ(receiver.height, 16u);
    EXPECT_EQ(receiver.reflectance, Vec3(0.5f));
    EXPECT_EQ(receiver.two_sided, receiver.id != "floor");
  }
}

TEST(PlanShadowsTest, UnknownIdsAreToldWithThoseThereAre) {
  const auto light = PlanShadows(Room(), {.light_ids = {"moon"}});
  EXPECT_EQ(light.status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(light.status().message(), "--light: found \"moon\", need one of: lamp, sun");
  const auto instance = PlanShadows(Room(), {.receiver_instances = {"wall"}});
  EXPECT_THAT(std::string(instance.status().message()), HasSubstr("box, small, large"));
}

TEST(PlanShadowsTest, InstancesThatAreNotFlatReceiveNothing) {
  const auto plan = PlanShadows(Room(), {.receiver_instances = {"box"}});
  EXPECT_EQ(plan.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(plan.status().message()),
              ::testing::StartsWith("--receiver-instance: found box, which "));
}

TEST(LargestPlanarInstancesTest, FlatOnesByArea) {
  EXPECT_THAT(LargestPlanarInstances(Room(), 5), ElementsAre("large", "small"));
  EXPECT_THAT(LargestPlanarInstances(Room(), 1), ElementsAre("large"));
  EXPECT_THAT(LargestPlanarInstances(Room(), 0), IsEmpty());
  ImportedScene room = Room();
  room.instances[2].receives = false;
  EXPECT_THAT(LargestPlanarInstances(room, 5), ElementsAre("small"));
}

}  // namespace
}  // namespace penumbra
