#include "client/cli/replace_scene.h"

#include <gtest/gtest.h>

#include "tests/support/shapes.h"

namespace penumbra {
namespace {

SceneDelta Content(std::vector<std::string> boxes) {
  static const auto mesh = testing::MeshOf(testing::UnitBoxGeometry());
  SceneDelta delta;
  for (const std::string& id : boxes) delta.upsert_instances.push_back({.id = id, .mesh = mesh});
  delta.upsert_lights = {{.id = "lamp", .shape = PointLight{.position = {0, 3, 0}}}};
  return delta;
}

TEST(ReplacementDeltaTest, LeavesTheSameSceneAsStartingAnew) {
  const auto before = *Scene::Empty("s")->Apply(Content({"a", "b", "c"}));
  SceneDelta wanted = Content({"b", "d"});
  wanted.upsert_instances[0].casts = false;
  const auto after = before->Apply(ReplacementDelta(*before, wanted));
  ASSERT_TRUE(after.ok()) << after.status();
  EXPECT_EQ((*after)->content_hash(), (*Scene::Empty("t")->Apply(wanted))->content_hash());
}

TEST(ReplacementDeltaTest, ReceiversOnSurfacesAreNamedOneByOne) {
  SceneDelta wanted = Content({"a"});
  wanted.receive_on_planar_surfaces = PlanarSurfaceRequest{};
  const auto empty = Scene::Empty("s");
  const auto scene = *empty->Apply(ReplacementDelta(*empty, wanted));
  EXPECT_EQ(scene->content_hash(), (*empty->Apply(wanted))->content_hash());
  EXPECT_TRUE(ReplacementDelta(*scene, wanted).empty());
}

TEST(ReplacementDeltaTest, WhatIsThereIsNotSentAgain) {
  const auto scene = *Scene::Empty("s")->Apply(Content({"a", "b"}));
  EXPECT_TRUE(ReplacementDelta(*scene, Content({"a", "b"})).empty());
  const SceneDelta delta = ReplacementDelta(*scene, Content({"a", "b", "c"}));
  ASSERT_EQ(delta.upsert_instances.size(), 1u);
  EXPECT_EQ(delta.upsert_instances[0].id, "c");
  EXPECT_TRUE(delta.upsert_lights.empty());
}

}  // namespace
}  // namespace penumbra
