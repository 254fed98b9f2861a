// The same on scenes of other authors, which are looked for where PENUMBRA_SCENES says.
#include <filesystem>
#include <iostream>
#include <string>

#include "client/import/import_scene.h"
#include "gtest/gtest.h"
#include "render/technique/technique.h"
#include "tests/accuracy/exactness.h"
#include "tests/accuracy/ledger.h"
#include "tests/support/scenes_folder.h"

namespace penumbra::testing {
namespace {

constexpr const char* kScenes[] = {
    "gazebo/gazebo.obj",
    "cornell-box/kajiya-gltf/scene.gltf",
    "kaykit-table-set/table_medium_decorated_A.glb",
    "mixed-lighting-chair/MixedLightingExample.gltf",
    "stanford-dragon-res2/dragon_vrip_res2.ply",
};

// Below the scene, three times as wide.
Receiver Floor(const Aabb& bounds) {
  const Vec3 extent = bounds.extent(), center = bounds.center();
  const float side = 3 * std::max(extent.x, extent.z);
  return {.id = "floor",
          .shape = Parallelogram{.origin = Vec3(center.x - 0.5f * side, bounds.min.y,
                                                center.z + 0.5f * side),
                                 .edge_u = Vec3(side, 0, 0),
                                 .edge_v = Vec3(0, 0, -side)},
          .width = 192,
          .height = 160};
}

// A slanting patch through the middle of everything.
Receiver Middle(const Aabb& bounds) {
  const Vec3 extent = bounds.extent() + Vec3(1e-3f);
  const Vec3 u = extent * Vec3(1, 0.2f, 0), v = extent * Vec3(0, 0.3f, -1);
  return {
      .id = "middle",
      .shape = Parallelogram{.origin = bounds.center() - 0.5f * (u + v), .edge_u = u, .edge_v = v},
      .width = 130,
      .height = 111};
}

AreaLight Overhead(const Aabb& bounds) {
  const Vec3 extent = bounds.extent();
  const float size = std::max({extent.x, extent.y, extent.z});
  return {"overhead", RectangleLight{.corner = bounds.center() + size * Vec3(0.2f, 1.3f, -0.1f),
                                     .edge_u = size * Vec3(0.5f, 0.1f, 0),
                                     .edge_v = size * Vec3(0, 0, 0.4f)}};
}

TEST(SceneExactnessTest, ScenesOfOtherAuthorsAgreeWithRays) {
  const auto folder = ScenesFolder(PENUMBRA_DEFAULT_SCENES);
  if (!std::filesystem::exists(folder)) {
    GTEST_SKIP() << folder << " is not there; PENUMBRA_SCENES names a folder of scenes";
  }
  Exactness total;
  for (const char* name : kScenes) {
    const auto imported = ImportScene(folder / name);
    ASSERT_TRUE(imported.ok()) << name << ": " << imported.status();
    const Aabb bounds = Bounds(*imported);
    SceneDelta delta = ToSceneDelta(*imported);
    delta.upsert_lights.push_back(Overhead(bounds));
    delta.upsert_receivers = {Floor(bounds), Middle(bounds)};
    const auto scene = Scene::Empty("s")->Apply(delta);
    ASSERT_TRUE(scene.ok()) << name << ": " << scene.status();
    Exactness one;
    for (const AreaLight& light : delta.upsert_lights) {
      for (const char* receiver : {"floor", "middle"}) {
        const ArtifactSpec spec{.params = SoftTextureParams{.samples = 64},
                                .light_id = light.id,
                                .receiver_id = receiver};
        tbb::task_arena arena;
        const ComputeContext context{.arena = arena};
        const auto artifact = TechniqueFor(spec.params).Compute(**scene, spec, context);
        ASSERT_TRUE(artifact.ok()) << name << ": " << artifact.status();
        one.Add(CompareWithRays(**scene, *artifact));
      }
    }
    std::cout << name << ": " << delta.upsert_lights.size() << " lights, texel-samples "
              << one.texel_samples << ", occluded " << one.occluded << ", differing "
              << one.differing << ", unexplained " << one.unexplained << ", largest slack "
              << one.largest_slack_ulps << " ulps\n";
    EXPECT_GT(one.occluded, 0u) << name;
    EXPECT_EQ(one.unexplained, 0u) << name;
    total.Add(one);
  }
  ExpectInLedger("exactness.scenes.differing_fraction", total.differing_fraction());
}

}  // namespace
}  // namespace penumbra::testing
