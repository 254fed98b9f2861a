#include "render/technique/soft_texture/outline_cost.h"

#include "gtest/gtest.h"
#include "render/technique/soft_texture/occluder_set.h"
#include "tests/support/rippled_torus.h"
#include "tests/unit/technique/soft_texture_scenes.h"

namespace penumbra::testing {
namespace {

// How many of the scene's casters `auto` draws from their outlines on a floor of `texels`².
size_t OutlinedOn(uint32_t texels, const std::vector<Instance>& instances) {
  SceneDelta delta{.upsert_instances = instances};
  delta.upsert_lights = {Ceiling(8)};
  delta.upsert_receivers = {Floor(texels, texels)};
  const auto scene = SceneOf(delta);
  const Parallelogram patch = scene->ResolveReceiver("floor").value().patch;
  const LightSample sample{.point = Vec3(0, 8, 0)};
  const auto map = ReceiverTransform::Create(patch, sample, 1e-5);
  const ShadowRegion region(*scene->FindLight("light"), patch);
  OccluderFrame frame(patch, 1, 1e-5);
  frame.region = &region;
  return PrepareOccluders(*scene, frame, {*map, texels, texels}, OutlineRule::kWhereCheaper, {})
      .outlined.size();
}

Instance Torus(uint32_t across, Vec3 place) {
  return {.id = "torus",
          .mesh = MeshOf(RippledTorus(8 * across, across)),
          .world_from_mesh = Placed(place, 1.0f)};
}

TEST(OutlineCostTest, ManyFacesOnFewTexelsAreDrawnFromTheirOutline) {
  EXPECT_EQ(OutlinedOn(256, {Torus(10, {0, 2, 0})}), 1u);
  EXPECT_EQ(OutlinedOn(2048, {Torus(10, {0, 2, 0})}), 0u);
  EXPECT_EQ(OutlinedOn(2048, {Torus(100, {0, 2, 0})}), 1u);
}

TEST(OutlineCostTest, AMeshThatHardlyReachesIntoTheRegionIsDrawnByItsClusters) {
  EXPECT_EQ(OutlinedOn(256, {Torus(100, {0, 2, 0})}), 1u);
  Instance beside = Torus(100, {0, 2, 0});
  beside.world_from_mesh = Placed({0, 2, 0}, 20.0f);
  beside.world_from_mesh[3] = Vec3(-19, 7.2f, 0);
  EXPECT_EQ(OutlinedOn(256, {beside}), 0u);
}

TEST(OutlineCostTest, BoxesAndLooseTrianglesAreFilled) {
  Instance box{.id = "box", .mesh = MeshOf(UnitBoxGeometry())};
  box.world_from_mesh = Placed({0, 2, 0}, 0.5f);
  EXPECT_EQ(OutlinedOn(64, {box}), 0u);
  EXPECT_LT(OutlineSavingNs({.faces = 500, .faces_in_region = 500, .border_edges = 1500}), 0);
}

}  // namespace
}  // namespace penumbra::testing
