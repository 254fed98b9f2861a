#include "client/cli/object_edit.h"

#include <gtest/gtest.h>

#include "render/scene/field_error.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

std::shared_ptr<const Scene> Studio() {
  SceneDelta delta;
  delta.upsert_instances = {
      {.id = "box", .mesh = MeshOf(UnitBoxGeometry()), .world_from_mesh = Placed({1, 2, 3}, 0.5f)},
      {.id = "lamp", .mesh = MeshOf(UnitBoxGeometry())}};
  delta.upsert_lights = {{.id = "lamp", .shape = SphereLight{.center = {0, 3, 0}}},
                         {.id = "panel", .shape = RectangleLight{.corner = {1, 1, 1}}},
                         {.id = "bulb", .shape = PointLight{.position = {1, 1, 1}}},
                         {.id = "sun", .shape = DistantLight{}}};
  return Scene::Empty("studio")->Apply(delta).value();
}

TEST(ObjectEditTest, WhatHasAPlaceMoves) {
  const auto scene = Studio();
  const auto box = MoveObject(*scene, "box", {1, 0, -1}).value();
  ASSERT_EQ(box.upsert_instances.size(), 1u);
  EXPECT_EQ(box.upsert_instances[0].world_from_mesh[3],
            scene->FindInstance("box")->world_from_mesh[3] + Vec3(1, 0, -1));
  EXPECT_EQ(box.upsert_instances[0].world_from_mesh[0],
            scene->FindInstance("box")->world_from_mesh[0]);
  EXPECT_TRUE(box.upsert_lights.empty());
  const auto lamp = MoveObject(*scene, "lamp", {0, 1, 0}).value();
  EXPECT_EQ(lamp.upsert_instances.size(), 1u) << "the thing that glows goes with its light";
  EXPECT_EQ(std::get<SphereLight>(lamp.upsert_lights.at(0).shape).center, Vec3(0, 4, 0));
  const auto panel = MoveObject(*scene, "panel", {0, 1, 0}).value();
  EXPECT_EQ(std::get<RectangleLight>(panel.upsert_lights.at(0).shape).corner, Vec3(1, 2, 1));
  EXPECT_EQ(ErrorReason(MoveObject(*scene, "sun", {0, 1, 0}).status()), "NO_PLACE");
  EXPECT_EQ(MoveObject(*scene, "moon", {0, 1, 0}).status().code(), absl::StatusCode::kNotFound);
}

TEST(ObjectEditTest, EveryLightHasAStrength) {
  const auto scene = Studio();
  const Vec3 rgb(1, 2, 3);
  const auto set = [&](const char* id) {
    return SetLightStrength(*scene, id, rgb).value().upsert_lights.at(0).shape;
  };
  EXPECT_EQ(std::get<SphereLight>(set("lamp")).radiance, rgb);
  EXPECT_EQ(std::get<RectangleLight>(set("panel")).radiance, rgb);
  EXPECT_EQ(std::get<PointLight>(set("bulb")).intensity, rgb);
  EXPECT_EQ(std::get<DistantLight>(set("sun")).irradiance, rgb);
  EXPECT_EQ(ErrorReason(SetLightStrength(*scene, "box", rgb).status()), "UNKNOWN_ID");
}

TEST(ObjectEditTest, AllOfAnIdGoes) {
  const auto scene = Studio();
  const auto lamp = RemoveObject(*scene, "lamp").value();
  const auto after = scene->Apply(lamp).value();
  EXPECT_FALSE(after->FindInstance("lamp"));
  EXPECT_FALSE(after->FindLight("lamp"));
  EXPECT_TRUE(after->FindInstance("box"));
  EXPECT_EQ(RemoveObject(*scene, "moon").status().code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace penumbra::testing
