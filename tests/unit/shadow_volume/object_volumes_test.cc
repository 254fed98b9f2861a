#include "render/technique/shadow_volume/object_volumes.h"

#include <gtest/gtest.h>

#include <map>
#include <string>

#include "render/light_view/auto_depth_source.h"
#include "render/scene/field_error.h"
#include "tests/support/pile_of_things.h"

namespace penumbra {
namespace {

using testing::PileOfThings;
using testing::Placed;

class ObjectVolumesTest : public ::testing::Test {
 protected:
  ObjectVolumes Make(ObjectPrecision precision = ObjectPrecision::kNever) {
    return ObjectVolumes({.resolution = 128}, precision);
  }
  static std::shared_ptr<const Scene> Pile() {
    SceneDelta delta;
    delta.upsert_instances = PileOfThings();
    return Scene::Empty("pile")->Apply(delta).value();
  }
  static std::shared_ptr<const Scene> Moved(const Scene& scene, const std::string& id, Vec3 to) {
    Instance instance = *scene.FindInstance(id);
    instance.world_from_mesh = Placed(to, 0.2f);
    SceneDelta delta;
    delta.upsert_instances = {instance};
    return scene.Apply(delta).value();
  }

  const AreaLight light_{.id = "light", .shape = PointLight{.position = Vec3(1, 7, 2)}};
  CasterBvhs bvhs_;
  tbb::task_arena arena_{2};
  const ObjectVolumes::SourceOf source_of_ = [this](const Scene& scene) {
    return std::make_unique<AutoDepthSource>(scene, bvhs_, arena_);
  };
};

TEST_F(ObjectVolumesTest, WhatMovesAloneIsMadeAnew) {
  ObjectVolumes volumes = Make();
  const auto scene = Pile();
  const auto before = volumes.Update(*scene, light_, source_of_, {}).value();
  EXPECT_EQ(volumes.made(), 40u);
  ASSERT_EQ(before.volumes.size(), 40u);
  EXPECT_EQ(volumes.Update(*scene, light_, source_of_, {}).value().volumes.size(), 40u);
  EXPECT_EQ(volumes.made(), 0u);
  const auto after =
      volumes.Update(*Moved(*scene, "piece7", Vec3(0.4f, 1, 0.3f)), light_, source_of_, {}).value();
  EXPECT_EQ(volumes.made(), 1u);
  for (size_t i = 0; i < 40; ++i) {
    EXPECT_EQ(before.volumes[i]->instance_id, after.volumes[i]->instance_id);
    const bool is_same = before.volumes[i]->content == after.volumes[i]->content;
    EXPECT_EQ(is_same, before.volumes[i]->instance_id != "piece7");
  }
  // The same as from nothing.
  ObjectVolumes fresh = Make();
  const auto again =
      fresh.Update(*Moved(*scene, "piece7", Vec3(0.4f, 1, 0.3f)), light_, source_of_, {}).value();
  for (size_t i = 0; i < 40; ++i) {
    EXPECT_EQ(again.volumes[i]->content, after.volumes[i]->content);
    EXPECT_EQ(again.volumes[i]->vertices, after.volumes[i]->vertices);
    EXPECT_EQ(again.volumes[i]->indices, after.volumes[i]->indices);
  }
}

TEST_F(ObjectVolumesTest, RemovedCastersHaveNoVolume) {
  ObjectVolumes volumes = Make();
  const auto scene = Pile();
  ASSERT_TRUE(volumes.Update(*scene, light_, source_of_, {}).ok());
  SceneDelta delta;
  delta.remove_instances = {"piece3"};
  const auto mesh = volumes.Update(*scene->Apply(delta).value(), light_, source_of_, {}).value();
  EXPECT_EQ(mesh.volumes.size(), 39u);
  for (const auto& volume : mesh.volumes) EXPECT_NE(volume->instance_id, "piece3");
}

// One map of each and their own edges agree, but at shadows' rims.
TEST_F(ObjectVolumesTest, MapsAndEdgesAgree) {
  const auto scene = Pile();
  const auto by_maps = Make().Update(*scene, light_, source_of_, {}).value();
  const auto by_edges =
      Make(ObjectPrecision::kWhereItIsLess).Update(*scene, light_, source_of_, {}).value();
  const VolumeLookup maps(by_maps), edges(by_edges);
  size_t dark = 0, different = 0;
  for (int i = 0; i < 2500; ++i) {
    const Vec3 at(0.12f * static_cast<float>(i % 50) - 3, 0,
                  0.12f * static_cast<float>(i / 50) - 3);
    const float a = maps.Visibility(at, Vec3(0, 1, 0)), b = edges.Visibility(at, Vec3(0, 1, 0));
    dark += b == 0;
    different += a != b;
  }
  EXPECT_GT(dark, 200u);
  EXPECT_LT(different, dark / 6);
}

TEST_F(ObjectVolumesTest, OptionsAreChecked) {
  ObjectVolumes volumes({.resolution = 4}, ObjectPrecision::kNever);
  const auto source_of = [](const Scene&) { return absl::InternalError("not asked for"); };
  const auto status = volumes.Update(*Pile(), light_, source_of, {}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(ErrorFieldPath(status), "resolution");
  EXPECT_EQ(ErrorReason(status), "RANGE");
}

TEST_F(ObjectVolumesTest, StopIsAskedFor) {
  std::stop_source stop;
  stop.request_stop();
  ObjectVolumes volumes = Make();
  EXPECT_EQ(volumes.Update(*Pile(), light_, source_of_, stop.get_token()).status().code(),
            absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace penumbra
