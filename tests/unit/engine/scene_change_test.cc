#include "render/engine/scene_change.h"

#include "gtest/gtest.h"
#include "tests/support/shapes.h"
#include "tests/unit/engine/scripted_technique.h"

namespace penumbra {
namespace {

using ::penumbra::testing::BoxAt;
using ::penumbra::testing::FloorReceiver;
using ::penumbra::testing::LampAndFloor;
using ::penumbra::testing::LampOnFloor;
using ::penumbra::testing::MeshOf;
using ::penumbra::testing::Placed;
using ::penumbra::testing::UnitSquareGeometry;

class SceneChangeTest : public ::testing::Test {
 protected:
  bool Affects(const SceneDelta& delta) {
    const auto after = before_->Apply(delta).value();
    return SceneChange(*before_, *after, delta).Affects(spec_, region_);
  }
  Instance Box() const { return *before_->FindInstance("box"); }
  void Have(const SceneDelta& delta) { before_ = before_->Apply(delta).value(); }

  std::shared_ptr<const Scene> before_ = Scene::Empty("s")->Apply(LampAndFloor()).value();
  ArtifactSpec spec_ = LampOnFloor();
  KnownShadowRegion region_;
};

TEST_F(SceneChangeTest, AnOccluderThatComesGoesOrMovesInTheWayAffects) {
  EXPECT_TRUE(Affects(BoxAt(0.05f)));
  EXPECT_TRUE(Affects(BoxAt(10))) << "it was in the way before";
  EXPECT_TRUE(Affects({.remove_instances = {"box"}}));
  Have(BoxAt(10));
  EXPECT_TRUE(Affects(BoxAt(0))) << "it is in the way after";
}

TEST_F(SceneChangeTest, OutOfTheWayDoesNot) {
  Have(BoxAt(10));
  EXPECT_FALSE(Affects(BoxAt(12)));
  EXPECT_FALSE(Affects({.remove_instances = {"box"}}));
  Instance another = Box();
  another.id = "another";
  EXPECT_FALSE(Affects({.upsert_instances = {another}}));
}

TEST_F(SceneChangeTest, ColourAndReceivesDoNotButWhatCastsDoes) {
  Instance painted = Box();
  painted.color = Vec3(0.1f, 0.2f, 0.3f);
  painted.receives = false;
  EXPECT_FALSE(Affects({.upsert_instances = {painted}}));
  Instance ghost = Box();
  ghost.casts = false;
  EXPECT_TRUE(Affects({.upsert_instances = {ghost}}));
  Instance holed = Box();
  holed.mesh = MeshOf(UnitSquareGeometry());
  holed.alpha_mask = AlphaMask::Create(1, 1, {0}).value();
  EXPECT_TRUE(Affects({.upsert_instances = {holed}}));
  Have({.upsert_instances = {holed}});
  holed.alpha_cutoff = 0.0f;
  EXPECT_TRUE(Affects({.upsert_instances = {holed}}));
}

TEST_F(SceneChangeTest, WhatNeverCastsMayMoveFreely) {
  Instance ghost = Box();
  ghost.casts = false;
  Have({.upsert_instances = {ghost}});
  ghost.world_from_mesh = Placed(Vec3(0.1f, 1, 0), 0.3f);
  EXPECT_FALSE(Affects({.upsert_instances = {ghost}}));
}

TEST_F(SceneChangeTest, LightAndReceiver) {
  EXPECT_FALSE(Affects({.upsert_lights = {*before_->FindLight("lamp")}})) << "equal to what was";
  EXPECT_TRUE(Affects({.upsert_lights = {{"lamp", PointLight{.position = Vec3(0, 3, 0)}}}}));
  EXPECT_FALSE(Affects({.upsert_lights = {{"other", PointLight{}}}}));
  EXPECT_TRUE(Affects({.remove_lights = {"lamp"}}));
  EXPECT_FALSE(Affects({.upsert_receivers = {FloorReceiver("floor", 1, 8)}}));
  EXPECT_TRUE(Affects({.upsert_receivers = {FloorReceiver("floor", 1, 16)}}));
  EXPECT_TRUE(Affects({.remove_receivers = {"floor"}}));
}

TEST_F(SceneChangeTest, OfAllSurfacesReceiversThatStandByThemselvesAreSome) {
  spec_ = {.params = LayeredAttenuationParams{}, .light_id = "lamp"};
  EXPECT_TRUE(Affects({.upsert_receivers = {FloorReceiver("floor", 2, 8)}}));
  EXPECT_TRUE(Affects({.upsert_receivers = {FloorReceiver("wall", 1, 8)}}));
  EXPECT_TRUE(Affects({.remove_receivers = {"floor"}}));
  EXPECT_FALSE(Affects({.upsert_receivers = {FloorReceiver("floor", 1, 8)}})) << "equal";
  const Receiver face{.id = "face", .shape = PlanarSurface{.instance_id = "box", .triangle = 0}};
  EXPECT_FALSE(Affects({.upsert_receivers = {face}})) << "of an instance, which is there already";
  Instance shy = Box();
  shy.receives = false;
  EXPECT_TRUE(Affects({.upsert_instances = {shy}}));
}

TEST_F(SceneChangeTest, APlanarReceiverFollowsItsInstance) {
  Instance table{.id = "table",
                 .mesh = MeshOf(UnitSquareGeometry()),
                 .world_from_mesh = Placed(Vec3(5, 0.5f, 0), 0.2f),
                 .casts = false};
  Have({.upsert_instances = {table},
        .upsert_receivers = {{.id = "top", .shape = PlanarInstance{"table"}}}});
  spec_.receiver_id = "top";
  EXPECT_FALSE(Affects(BoxAt(-0.2f)));
  table.color = Vec3(0.5f);
  EXPECT_FALSE(Affects({.upsert_instances = {table}}));
  table.world_from_mesh = Placed(Vec3(5, 0.6f, 0), 0.2f);
  EXPECT_TRUE(Affects({.upsert_instances = {table}}));
}

Instance SmallBox(std::string id, Vec3 place) {
  return {.id = std::move(id),
          .mesh = MeshOf(testing::UnitBoxGeometry()),
          .world_from_mesh = Placed(place, 0.2f)};
}

// An artifact of all lights: any change of any of them, and what lies between any of them and the
// receiver.
TEST(SceneChangeOfAllLights, AnyLightMatters) {
  const AreaLight near{"near", PointLight{.position = Vec3(0, 2, 0)}};
  const AreaLight aside{"aside", PointLight{.position = Vec3(50, 2, 0)}};
  Instance box = SmallBox("box", Vec3(25, 1, 0));
  const auto scene = Scene::Empty("s")
                         ->Apply({.upsert_instances = {box},
                                  .upsert_lights = {near, aside},
                                  .upsert_receivers = {FloorReceiver("floor", 2, 8)}})
                         .value();
  const auto affects = [&](const std::string& light_id, const SceneDelta& delta) {
    const auto after = scene->Apply(delta).value();
    KnownShadowRegion region;
    SceneChange change(*scene, *after, delta);
    return change.Affects({SoftTextureParams{}, light_id, "floor"}, region);
  };
  AreaLight brighter = aside;
  std::get<PointLight>(brighter.shape).intensity = Vec3(2);
  EXPECT_TRUE(affects("*", {.upsert_lights = {brighter}}));
  EXPECT_FALSE(affects("near", {.upsert_lights = {brighter}}));
  EXPECT_TRUE(affects("*", {.remove_lights = {"aside"}}));
  EXPECT_TRUE(affects("*", {.upsert_lights = {{"third", PointLight{}}}}));
  EXPECT_FALSE(affects("*", {.upsert_lights = {aside}}));
  box.world_from_mesh[3] += Vec3(1, 0, 0);
  EXPECT_TRUE(affects("*", {.upsert_instances = {box}}));
  EXPECT_FALSE(affects("near", {.upsert_instances = {box}}));
  EXPECT_FALSE(affects("*", {.upsert_instances = {SmallBox("high", Vec3(0, 9, 0))}}));
}

TEST_F(SceneChangeTest, AReceiverOnASurfaceFollowsItsInstanceToo) {
  MeshGeometry half = UnitSquareGeometry();
  half.indices.resize(3);
  Instance table{.id = "table",
                 .mesh = MeshOf(UnitSquareGeometry()),
                 .world_from_mesh = Placed(Vec3(5, 0.5f, 0), 0.2f),
                 .casts = false};
  Have({.upsert_instances = {table},
        .upsert_receivers = {{.id = "top", .shape = PlanarSurface{"table", 1}},
                             {.id = "all", .shape = PlanarInstance{"table"}}}});
  spec_.receiver_id = "top";
  table.color = Vec3(0.5f);
  EXPECT_FALSE(Affects({.upsert_instances = {table}}));
  table.world_from_mesh = Placed(Vec3(5, 0.6f, 0), 0.2f);
  EXPECT_TRUE(Affects({.upsert_instances = {table}}));
  table.world_from_mesh = Placed(Vec3(5, 0.5f, 0), 0.2f);
  table.mesh = MeshOf(half);
  spec_.receiver_id = "all";
  EXPECT_TRUE(Affects({.upsert_instances = {table}, .remove_receivers = {"top"}}))
      << "other texels are inside, if in the same patch";
}

}  // namespace
}  // namespace penumbra
