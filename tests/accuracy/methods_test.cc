// Every way to draw a hard shadow gives the same counts, texel for texel.
#include <algorithm>

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

// A sun straight overhead and along the other axes, over a fine ball: where a scene set up by hand
// has its faces edge-on to the bit.
TEST(MethodsTest, AgreeUnderASunAlongAnAxis) {
  for (const Vec3 to_light : {Vec3(0, 1, 0), Vec3(1, 1, 0), Vec3(0, 1, -1)}) {
    for (const float diameter : {0.0f, 0.1f}) {
      SceneDelta delta;
      delta.upsert_instances = {{.id = "ball",
                                 .mesh = MeshOf(BallGeometry(64, 48)),
                                 .world_from_mesh = Placed(Vec3(0, 1.5f, 0))}};
      delta.upsert_receivers = {FloorReceiver("receiver", 6, 100)};
      delta.upsert_lights = {
          {.id = "light",
           .shape = DistantLight{.to_light = to_light, .angular_diameter = diameter}}};
      const auto scene = Scene::Empty("s")->Apply(delta).value();
      const auto expected = CountsBy(VisibilityMethod::kCoverage, *scene, 9);
      EXPECT_GT(std::count(expected.begin(), expected.end(), 0), 500);
      for (const VisibilityMethod method : kMethods) {
        EXPECT_EQ(CountsBy(method, *scene, 9), expected) << static_cast<int>(method);
      }
    }
  }
}

}  // namespace
}  // namespace penumbra::testing
