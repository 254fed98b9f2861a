#include "proto/convert/scene_convert.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "proto/convert/light_convert.h"
#include "render/scene/field_error.h"
#include "tests/support/random_scene.h"
#include "tests/support/shapes.h"

namespace penumbra {
namespace {

// The blobs of one scene.
class SceneBlobs : public BlobSource {
 public:
  explicit SceneBlobs(const Scene& scene) {
    for (const auto& [id, instance] : scene.instances()) {
      if (instance->mesh) meshes_[instance->mesh->id()] = instance->mesh;
      if (instance->alpha_mask) masks_[instance->alpha_mask->id()] = instance->alpha_mask;
    }
  }
  std::shared_ptr<const Mesh> FindMesh(const ContentHash& hash) const override {
    const auto mesh = meshes_.find(hash);
    return mesh == meshes_.end() ? nullptr : mesh->second;
  }
  std::shared_ptr<const AlphaMask> FindMask(const ContentHash& hash) const override {
    const auto mask = masks_.find(hash);
    return mask == masks_.end() ? nullptr : mask->second;
  }

 private:
  std::map<ContentHash, std::shared_ptr<const Mesh>> meshes_;
  std::map<ContentHash, std::shared_ptr<const AlphaMask>> masks_;
};

SceneDelta ContentOf(const Scene& scene) {
  SceneDelta delta;
  for (const auto& [id, object] : scene.instances()) delta.upsert_instances.push_back(*object);
  for (const auto& [id, object] : scene.lights()) delta.upsert_lights.push_back(*object);
  for (const auto& [id, object] : scene.receivers()) delta.upsert_receivers.push_back(*object);
  return delta;
}

// Through bytes, as on the wire.
v1::SceneDelta Sent(const v1::SceneDelta& proto) {
  v1::SceneDelta received;
  EXPECT_TRUE(received.ParseFromString(proto.SerializeAsString()));
  return received;
}

TEST(SceneConvertTest, RandomScenesGoThereAndBack) {
  for (uint64_t seed = 0; seed < 60; ++seed) {
    const auto scene = testing::RandomScene(seed);
    const SceneBlobs blobs(*scene);
    const SceneDelta content = ContentOf(*scene);
    const auto back = FromProto(Sent(ToProto(content)), blobs);
    ASSERT_TRUE(back.ok()) << back.status();
    EXPECT_EQ(back->upsert_instances, content.upsert_instances) << seed;
    EXPECT_EQ(back->upsert_lights, content.upsert_lights) << seed;
    EXPECT_EQ(back->upsert_receivers, content.upsert_receivers) << seed;
    const auto copy = Scene::Empty("copy")->Apply(*back);
    ASSERT_TRUE(copy.ok()) << copy.status();
    EXPECT_EQ((*copy)->content_hash(), scene->content_hash()) << seed;
  }
}

TEST(SceneConvertTest, RemovalsAndBaseGoThereAndBack) {
  const SceneDelta delta{.base_revision = 7,
                         .upsert_instances = {},
                         .remove_instances = {"a", "b"},
                         .upsert_lights = {},
                         .remove_lights = {"c"},
                         .upsert_receivers = {},
                         .remove_receivers = {"d", "e", "f"}};
  const auto back = FromProto(Sent(ToProto(delta)), SceneBlobs(*Scene::Empty("none")));
  ASSERT_TRUE(back.ok());
  EXPECT_EQ(back->base_revision, delta.base_revision);
  EXPECT_EQ(back->remove_instances, delta.remove_instances);
  EXPECT_EQ(back->remove_lights, delta.remove_lights);
  EXPECT_EQ(back->remove_receivers, delta.remove_receivers);
  EXPECT_FALSE(FromProto(v1::SceneDelta(), SceneBlobs(*Scene::Empty("none")))->base_revision);
}

TEST(SceneConvertTest, WhatIsAbsentHasTheDefaultOfTheDomain) {
  v1::Light light;
  light.set_id("l");
  light.mutable_rectangle();
  EXPECT_EQ(*FromProto(light, "l"), (AreaLight{"l", RectangleLight{}}));
  light.mutable_disk();
  EXPECT_EQ(*FromProto(light, "l"), (AreaLight{"l", DiskLight{}}));
  light.mutable_sphere();
  EXPECT_EQ(*FromProto(light, "l"), (AreaLight{"l", SphereLight{}}));
  light.mutable_point();
  EXPECT_EQ(*FromProto(light, "l"), (AreaLight{"l", PointLight{}}));
  light.mutable_spot();
  EXPECT_EQ(*FromProto(light, "l"), (AreaLight{"l", SpotLight{}}));
  light.mutable_distant();
  EXPECT_EQ(*FromProto(light, "l"), (AreaLight{"l", DistantLight{}}));
  v1::Receiver receiver;
  receiver.mutable_parallelogram();
  EXPECT_EQ(*FromProto(receiver, "r"), (Receiver{.id = "", .shape = Parallelogram{}}));
  const auto box = testing::MeshOf(testing::UnitBoxGeometry());
  const auto scene = *Scene::Empty("s")->Apply({.base_revision = {},
                                                .upsert_instances = {{.id = "box", .mesh = box}},
                                                .remove_instances = {},
                                                .upsert_lights = {},
                                                .remove_lights = {},
                                                .upsert_receivers = {},
                                                .remove_receivers = {}});
  v1::Instance instance;
  instance.set_mesh_hash(box->id().bytes.data(), 32);
  EXPECT_EQ(*FromProto(instance, SceneBlobs(*scene), "i"), (Instance{.id = "", .mesh = box}));
}

TEST(SceneConvertTest, TransformsAreColumnsOfThree) {
  Instance instance{.id = "i"};
  instance.world_from_mesh = Affine(Vec3(1, 2, 3), Vec3(4, 5, 6), Vec3(7, 8, 9), Vec3(10, 11, 12));
  EXPECT_THAT(ToProto(instance).world_from_mesh(),
              ::testing::ElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12));
}

TEST(SceneConvertTest, PiecesAreSmallAndAddUp) {
  SceneDelta content;
  const auto box = testing::MeshOf(testing::UnitBoxGeometry());
  for (int i = 0; i < 500; ++i) {
    content.upsert_instances.push_back({.id = "box" + std::to_string(i), .mesh = box});
    content.upsert_receivers.push_back(
        testing::FloorReceiver("floor" + std::to_string(i), 1.0f, 8));
  }
  const auto scene = *Scene::Empty("all")->Apply(content);
  const SceneBlobs blobs(*scene);
  const auto pieces = ToProtoPieces(content, 4096);
  EXPECT_GT(pieces.size(), 10u);
  v1::SceneDelta whole;
  for (const auto& piece : pieces) {
    EXPECT_LE(piece.ByteSizeLong(), 4096u);
    whole.MergeFrom(piece);
  }
  const auto copy = *Scene::Empty("copy")->Apply(*FromProto(whole, blobs));
  EXPECT_EQ(copy->content_hash(), scene->content_hash());
  EXPECT_EQ(ToProtoPieces({}, 4096).size(), 1u) << "an empty change is a change";
}

TEST(SceneConvertTest, LimitsThatWereNotToldKeepTheirDefaults) {
  v1::Limits proto;
  WriteSceneLimits({.max_lights = 7}, proto);
  proto.set_max_instances(0);
  const SceneLimits limits = SceneLimitsFromProto(proto);
  EXPECT_EQ(limits.max_lights, 7u);
  EXPECT_EQ(limits.max_instances, SceneLimits().max_instances);
  EXPECT_EQ(limits.max_coordinate, SceneLimits().max_coordinate);
}

}  // namespace
}  // namespace penumbra
