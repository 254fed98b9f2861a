// Every way to draw a hard shadow gives the same counts, texel for texel.
#include "gtest/gtest.h"
#include "render/technique/technique.h"
#include "tests/support/random_scene.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

constexpr VisibilityMethod kMethods[] = {VisibilityMethod::kAuto, VisibilityMethod::kEdgeFlag,
                                         VisibilityMethod::kSilhouette};

std::vector<uint16_t> CountsBy(VisibilityMethod method, const Scene& scene, uint32_t samples) {
  const ArtifactSpec spec{.params = SoftTextureParams{.samples = samples, .method = method},
                          .light_id = "light",
                          .receiver_id = "receiver"};
  tbb::task_arena arena(2);
  const Artifact artifact =
      TechniqueFor(spec.params).Compute(scene, spec, {.arena = arena}).value();
  return std::get<SoftShadowTexture>(artifact.payload).visibility.counts;
}

// Open, closed, no manifolds, self-intersecting, mirrored, flat, cut by the receiver's plane,
// around the light: RandomScene has it all.
TEST(MethodsTest, AgreeOnRandomScenes) {
  int differing_scenes = 0;
  for (uint64_t seed = 0; seed < 1000; ++seed) {
    const auto scene = RandomScene(seed);
    const auto expected = CountsBy(VisibilityMethod::kCoverage, *scene, 9);
    for (const VisibilityMethod method : kMethods) {
      const auto counts = CountsBy(method, *scene, 9);
      size_t differing = 0;
      for (size_t i = 0; i < counts.size(); ++i) differing += counts[i] != expected[i];
      EXPECT_EQ(differing, 0u) << "scene " << seed << ", method " << static_cast<int>(method)
                               << ", of " << counts.size() << " texels";
      differing_scenes += differing > 0;
    }
  }
  EXPECT_EQ(differing_scenes, 0);
}

}  // namespace
}  // namespace penumbra::testing
