// Leaving out what cannot cast changes no count.
#include "gtest/gtest.h"
#include "render/technique/soft_texture/occlusion_counter.h"
#include "tests/support/random_scene.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

constexpr VisibilityMethod kMethods[] = {VisibilityMethod::kCoverage, VisibilityMethod::kEdgeFlag,
                                         VisibilityMethod::kSilhouette};

std::vector<uint16_t> Counts(const Scene& scene, const ShadowRules& rules, uint32_t samples) {
  const ReceiverPatch receiver = scene.ResolveReceiver("receiver").value();
  const AreaLight& light = *scene.FindLight("light");
  OcclusionCounter counter(scene, light, receiver, 1e-5, rules);
  tbb::task_arena arena(2);
  const auto points = SampleLight(light, samples, 1, receiver.patch.At(Vec2(0.5f)));
  counter.CountDown(std::vector<uint16_t>(size_t{receiver.width} * receiver.height, samples));
  EXPECT_TRUE(counter.Add(points, arena, {}).ok());
  std::vector<uint16_t> hidden = counter.TakeCounts();
  for (uint16_t& count : hidden) count = static_cast<uint16_t>(samples - count);
  return hidden;
}

uint64_t Sum(const std::vector<uint16_t>& counts) {
  uint64_t sum = 0;
  for (const uint16_t count : counts) sum += count;
  return sum;
}

TEST(CullingTest, ChangesNoCountOfARandomScene) {
  uint64_t hidden = 0;
  for (uint64_t seed = 0; seed < 1000; ++seed) {
    const auto scene = RandomScene(seed);
    const VisibilityMethod method = kMethods[seed / kLightKinds % 3];
    const auto expected = Counts(*scene, {.method = method, .cull = false}, 9);
    ASSERT_EQ(Counts(*scene, {.method = method}, 9), expected) << "scene " << seed;
    hidden += Sum(expected);
  }
  EXPECT_GT(hidden, 1'000'000u);
}

// A crumpled sheet of many triangles, with a bump for every seed.
std::shared_ptr<const Mesh> Terrain(Dice& dice, uint32_t side) {
  MeshGeometry sheet;
  for (uint32_t i = 0; i <= side; ++i) {
    for (uint32_t j = 0; j <= side; ++j) {
      const Vec2 at = 2.0f * Vec2(i, j) / static_cast<float>(side) - 1.0f;
      sheet.positions.emplace_back(at.x, dice.Between(-0.05f, 0.05f), at.y);
    }
  }
  for (uint32_t i = 0; i < side; ++i) {
    for (uint32_t j = 0; j < side; ++j) {
      const uint32_t a = i * (side + 1) + j, b = a + side + 1;
      sheet.indices.insert(sheet.indices.end(), {a, a + 1, b, a + 1, b + 1, b});
    }
  }
  return MeshOf(std::move(sheet));
}

// Small receivers anywhere among large meshes and many small ones: most is left out, clusters of
// meshes among it, and in textures of several bands too.
TEST(CullingTest, ChangesNoCountWhereMostIsLeftOut) {
  uint64_t hidden = 0;
  for (uint64_t seed = 0; seed < 120; ++seed) {
    Dice dice(1000 + seed);
    SceneDelta delta;
    const auto box = MeshOf(UnitBoxGeometry());
    for (int i = 0; i < 300; ++i) {
      delta.upsert_instances.push_back(
          {.id = "box" + std::to_string(i),
           .mesh = box,
           .world_from_mesh = dice.AnyAffine(dice.Between(0.02f, 0.2f), dice.InCube(4))});
    }
    for (int i = 0; i < 3; ++i) {
      delta.upsert_instances.push_back({.id = "terrain" + std::to_string(i),
                                        .mesh = Terrain(dice, 40),
                                        .world_from_mesh = dice.AnyAffine(3, dice.InCube(3))});
    }
    const Vec3 u = dice.Direction();
    const Vec3 v = glm::normalize(glm::cross(u, dice.Direction()));
    const bool is_tall = seed % 10 == 0;
    delta.upsert_receivers = {
        {.id = "receiver",
         .shape = Parallelogram{.origin = dice.InCube(3), .edge_u = u, .edge_v = v},
         .width = is_tall ? 1100 : 1 + dice.Below(60),
         .height = is_tall ? 520 : 1 + dice.Below(60)}};
    delta.upsert_lights = {RandomLight(dice, static_cast<int>(seed % kLightKinds))};
    const auto scene = Scene::Empty("culled")->Apply(delta).value();
    const VisibilityMethod method = kMethods[seed / kLightKinds % 3];
    const auto expected = Counts(*scene, {.method = method, .cull = false}, 5);
    ASSERT_EQ(Counts(*scene, {.method = method}, 5), expected) << "scene " << seed;
    hidden += Sum(expected);
  }
  EXPECT_GT(hidden, 100'000u);
}

}  // namespace
}  // namespace penumbra::testing
