// The sample scene: written by its generator, and what its page says it is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <vector>

#include "client/import/import_scene.h"
#include "deploy/scenes/atelier.h"
#include "render/scene/receiver.h"
#include "tests/unit/import/temp_folder.h"

namespace penumbra {
namespace {

constexpr size_t kMaxBytes = 300 * 1024;

TEST(Sample, TheGeneratorWritesTheCommittedBytes) {
  std::ifstream file(PENUMBRA_SAMPLE, std::ios::binary);
  const std::vector<char> committed{std::istreambuf_iterator<char>(file), {}};
  const std::vector<uint8_t> generated = sample::AtelierGlb();
  ASSERT_EQ(committed.size(), generated.size());
  EXPECT_LT(committed.size(), kMaxBytes);
  EXPECT_TRUE(std::equal(committed.begin(), committed.end(), generated.begin(),
                         [](char a, uint8_t b) { return static_cast<uint8_t>(a) == b; }));
}

TEST(Sample, HoldsWhatItsPageLists) {
  const auto scene = ImportScene(PENUMBRA_SAMPLE);
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_THAT(scene->warnings, testing::IsEmpty());
  EXPECT_TRUE(Scene::Empty("s")->Apply(ToSceneDelta(*scene)).ok());
  for (const char* id : {"floor", "wall"}) {
    EXPECT_TRUE(BoundingParallelogram(InstanceOf(*scene, id)).ok()) << id;
  }
  EXPECT_TRUE(InstanceOf(*scene, "vase").casts);
  EXPECT_NE(InstanceOf(*scene, "leaves").alpha_mask, nullptr);
  EXPECT_EQ(InstanceOf(*scene, "fruit-1").mesh.get(), InstanceOf(*scene, "fruit-3").mesh.get());
  EXPECT_EQ(scene->cameras.size(), 1u);
}

TEST(Sample, ItsLampsShineOnTheTable) {
  const auto scene = ImportScene(PENUMBRA_SAMPLE);
  ASSERT_TRUE(scene.ok()) << scene.status();
  const auto softbox = std::get<RectangleLight>(LightOf(*scene, "softbox").shape);
  const Vec3 table(0, 0.76f, 0);
  const Vec3 front = glm::cross(softbox.edge_u, softbox.edge_v);
  EXPECT_GT(glm::dot(front, table - softbox.corner), 0.0f);
  EXPECT_NEAR(glm::length(front), 0.8f, 1e-3f);
  EXPECT_NEAR(std::get<SphereLight>(LightOf(*scene, "lantern").shape).radius, 0.05f, 1e-3f);
  EXPECT_FALSE(InstanceOf(*scene, "lantern").casts);
}

}  // namespace
}  // namespace penumbra
