// Counts by GL against those of the CPU, and against rays.
#include <gtest/gtest.h>

#include <cstdlib>
#include <iostream>

#include "tests/accuracy/exactness.h"
#include "tests/gl/display/software_context.h"
#include "tests/gl/soft_texture/gl_scenes.h"
#include "tests/support/random_scene.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

class GlCountsTest : public SoftwareContextTest {};

// How many scenes: 200, or as many as the variable says.
uint64_t SceneCount() {
  const char* count = std::getenv("PENUMBRA_GL_SCENES");
  return count ? std::strtoull(count, nullptr, 10) : 200;
}

TEST_F(GlCountsTest, AgreeWithTheCpuOnRandomScenes) {
  uint64_t texel_samples = 0, differing = 0, hidden = 0, differing_scenes = 0;
  Exactness judged;
  for (uint64_t seed = 0; seed < SceneCount(); ++seed) {
    const auto scene = RandomScene(seed);
    const SoftTextureParams params{.samples = 9 + static_cast<uint32_t>(seed % 70)};
    const auto by_gl = ComputeOnGl(*context_, *scene, params);
    ASSERT_TRUE(by_gl.ok()) << by_gl.status();
    const Artifact by_cpu = ComputeOnCpu(*scene, params);
    const uint64_t one = DifferingSamples(*by_gl, by_cpu);
    const VisibilityMap& map = TextureOf(*by_gl).visibility;
    texel_samples += map.counts.size() * map.sample_count;
    for (const uint16_t count : map.counts) hidden += map.sample_count - count;
    differing += one;
    if (one == 0) continue;
    ++differing_scenes;
    const Exactness against_rays = CompareWithRays(*scene, *by_gl);
    EXPECT_EQ(against_rays.unexplained, 0u) << "scene " << seed << ", " << one << " differ";
    judged.Add(against_rays);
  }
  std::cout << "texel-samples " << texel_samples << ", hidden " << hidden << ", differing "
            << differing << " in " << differing_scenes << " scenes; of those against rays "
            << judged.differing << " differ, " << judged.unexplained
            << " unexplained, largest slack " << judged.largest_slack_ulps << " ulps\n";
  EXPECT_LE(static_cast<double>(differing), 1e-4 * static_cast<double>(texel_samples));
  EXPECT_GT(hidden, texel_samples / 10);
  EXPECT_LT(hidden, texel_samples * 9 / 10);
}

}  // namespace
}  // namespace penumbra::testing
