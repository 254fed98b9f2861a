#include "tests/accuracy/exactness.h"

#include <cstdlib>
#include <iostream>

#include "gtest/gtest.h"
#include "render/technique/technique.h"
#include "tbb/global_control.h"
#include "tests/accuracy/ledger.h"
#include "tests/support/random_scene.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

constexpr uint64_t kScenes = 100;

Artifact Compute(const Scene& scene, uint32_t samples, int threads) {
  const ArtifactSpec spec{.params = SoftTextureParams{.samples = samples, .seed = 3},
                          .light_id = "light",
                          .receiver_id = "receiver"};
  tbb::task_arena arena(threads);
  const ComputeContext context{.arena = arena};
  return TechniqueFor(spec.params).Compute(scene, spec, context).value();
}

TEST(ExactnessTest, HundredRandomScenesAgreeWithRays) {
  Exactness total;
  for (uint64_t seed = 0; seed < kScenes; ++seed) {
    const auto scene = RandomScene(seed);
    const Exactness one = CompareWithRays(*scene, Compute(*scene, 16 + seed % 50, 2));
    EXPECT_EQ(one.unexplained, 0u) << "scene " << seed << ", of " << one.texel_samples
                                   << " texel-samples " << one.differing << " differ";
    total.Add(one);
  }
  std::cout << "texel-samples " << total.texel_samples << ", occluded " << total.occluded
            << ", differing " << total.differing << ", largest slack " << total.largest_slack_ulps
            << " ulps\n";
  EXPECT_GT(total.occluded, total.texel_samples / 10);
  EXPECT_LT(total.occluded, total.texel_samples * 9 / 10);
  ExpectInLedger("exactness.random.differing_fraction", total.differing_fraction());
  ExpectInLedger("exactness.random.unexplained", static_cast<double>(total.unexplained));
}

// A lamp whose glowing face is a mesh that casts: it must not shadow its own light.
TEST(ExactnessTest, ALightMayLieInASurface) {
  for (const float tilt : {0.0f, 0.37f}) {
    const RectangleLight light{.corner = Vec3(-0.5f, 2.1f, 0.3f),
                               .edge_u = Vec3(1.1f, tilt, 0.1f),
                               .edge_v = Vec3(0.2f, 0, -0.9f)};
    const Instance face{
        .id = "face",
        .mesh = MeshOf(UnitSquareGeometry()),
        .world_from_mesh = Affine(0.5f * light.edge_u, Vec3(0, 1, 0), -0.5f * light.edge_v,
                                  light.corner + 0.5f * light.edge_u + 0.5f * light.edge_v)};
    const auto scene = Scene::Empty("s")
                           ->Apply({.upsert_instances = {face},
                                    .upsert_lights = {{"light", light}},
                                    .upsert_receivers = {FloorReceiver("receiver", 4, 33)}})
                           .value();
    const Exactness result = CompareWithRays(*scene, Compute(*scene, 64, 2));
    EXPECT_EQ(result.occluded, 0u);
    EXPECT_EQ(result.differing, 0u) << "of " << result.texel_samples;
  }
}

// What would a wrong count look like? Almost every one is seen to be wrong.
TEST(ExactnessTest, WrongCountsAreNotExplainedAway) {
  uint64_t changed = 0, unexplained = 0;
  for (uint64_t seed = 0; seed < 12; ++seed) {
    const auto scene = RandomScene(seed);
    Artifact artifact = Compute(*scene, 16, 2);
    auto& counts = std::get<SoftShadowTexture>(artifact.payload).visibility.counts;
    for (size_t t = 0; t < counts.size(); t += 1 + counts.size() / 20) {
      counts[t] += counts[t] > 0 ? -1 : 1;
      ++changed;
    }
    unexplained += CompareWithRays(*scene, artifact).unexplained;
  }
  EXPECT_GE(unexplained, changed * 99 / 100);
}

TEST(ExactnessTest, TheSameBitsForAnyNumberOfThreads) {
  const tbb::global_control four(tbb::global_control::max_allowed_parallelism, 4);
  for (uint64_t seed = 0; seed < kScenes; seed += 3) {
    const auto scene = RandomScene(seed);
    const auto counts = [&](int threads) {
      return std::get<SoftShadowTexture>(Compute(*scene, 40, threads).payload).visibility.counts;
    };
    const auto alone = counts(1);
    EXPECT_EQ(alone, counts(2)) << "scene " << seed;
    EXPECT_EQ(alone, counts(4)) << "scene " << seed;
  }
}

}  // namespace
}  // namespace penumbra::testing
