#include "client/display/draw_list.h"

#include <gtest/gtest.h>

#include <variant>

#include "client/display/suggest_ambient.h"
#include "client/display/surface_glsl.h"

namespace penumbra {
namespace {

std::shared_ptr<const Mesh> Triangle(float height) {
  return *Mesh::Create({.positions = {{0, height, 0}, {1, height, 0}, {0, height, 1}},
                        .indices = {0, 1, 2},
                        .normals = {},
                        .uvs = {}});
}

Receiver Patch(const std::string& id, float height, uint32_t width = 3) {
  return {
      .id = id,
      .shape = Parallelogram{.origin = {0, height, 0}, .edge_u = {0, 0, 2}, .edge_v = {2, 0, 0}},
      .width = width,
      .height = 3};
}

std::shared_ptr<const Artifact> ArtifactFor(const Receiver& receiver, const std::string& light_id) {
  auto artifact = std::make_shared<Artifact>();
  artifact->header.light_id = light_id;
  artifact->header.receiver_id = receiver.id;
  SoftShadowTexture texture;
  texture.receiver.patch = std::get<Parallelogram>(receiver.shape);
  texture.visibility = {.width = receiver.width,
                        .height = receiver.height,
                        .sample_count = 1,
                        .counts = std::vector<uint16_t>(receiver.width * receiver.height, 1)};
  artifact->payload = std::move(texture);
  return artifact;
}

std::shared_ptr<const Scene> TwoFloors() {
  auto scene = Scene::Empty("s")->Apply(
      {.upsert_instances = {{.id = "low", .mesh = Triangle(0)},
                            {.id = "high", .mesh = Triangle(5)}},
       .upsert_lights = {{.id = "a", .shape = PointLight{}}, {.id = "b", .shape = SphereLight{}}},
       .upsert_receivers = {Patch("ground", 0), Patch("roof", 5, 4)}});
  EXPECT_TRUE(scene.ok()) << scene.status();
  return *scene;
}

TEST(DrawListTest, SurfacesGetTheArtifactsOfTheirPlaneInTheOrderOfLights) {
  const auto scene = TwoFloors();
  const DrawList list = BuildDrawList(
      *scene,
      std::vector{ArtifactFor(Patch("roof", 5, 4), "b"), ArtifactFor(Patch("ground", 0), "b"),
                  ArtifactFor(Patch("ground", 0), "a")},
      /*draws_lights=*/false);
  ASSERT_EQ(list.items.size(), 4u) << "two instances, two free-standing receivers";
  ASSERT_EQ(list.receivers.size(), 3u);
  // Instances come in the order of ids: "high", "low".
  const DrawItem &high = list.items[0], &low = list.items[1], &ground = list.items[2];
  ASSERT_EQ(high.end_candidate - high.first_candidate, 1u);
  EXPECT_EQ(list.candidates[high.first_candidate].light, 1u);
  EXPECT_EQ(list.candidates[high.first_candidate].receiver, 0u);
  ASSERT_EQ(low.end_candidate - low.first_candidate, 2u);
  EXPECT_EQ(list.candidates[low.first_candidate].light, 0u);
  EXPECT_EQ(list.candidates[low.first_candidate].receiver, 2u);
  EXPECT_EQ(list.candidates[low.first_candidate + 1].receiver, 1u);
  EXPECT_EQ(list.candidates[ground.first_candidate].receiver, 2u | kIsTheReceiver);
  EXPECT_LT(ground.depth_scale, 1) << "steps back behind instances";
}

TEST(DrawListTest, CountsOfOddSizesStartAtEvenPlaces) {
  const auto scene = TwoFloors();
  const DrawList list = BuildDrawList(
      *scene,
      std::vector{ArtifactFor(Patch("ground", 0), "a"), ArtifactFor(Patch("roof", 5, 4), "a")},
      false);
  ASSERT_EQ(list.receivers.size(), 2u);
  EXPECT_EQ(list.receivers[0].first_texel, 0u);
  EXPECT_EQ(list.receivers[1].first_texel, 10u) << "9 texels and one of padding";
  EXPECT_EQ(list.texel_count, 22u);
}

TEST(DrawListTest, IgnoresArtifactsThatSayNothing) {
  const auto scene = TwoFloors();
  auto short_counts = std::make_shared<Artifact>(*ArtifactFor(Patch("ground", 0), "a"));
  std::get<SoftShadowTexture>(short_counts->payload).visibility.counts.pop_back();
  const DrawList list =
      BuildDrawList(*scene,
                    std::vector<std::shared_ptr<const Artifact>>{
                        nullptr, short_counts, ArtifactFor(Patch("ground", 0), "gone"),
                        ArtifactFor(Patch("gone", 0), "a")},
                    false);
  EXPECT_TRUE(list.receivers.empty());
  EXPECT_TRUE(list.candidates.empty());
}

TEST(DrawListTest, OnlyLightsWithAShapeGlow) {
  const auto scene = TwoFloors();
  const DrawList list = BuildDrawList(*scene, {}, /*draws_lights=*/true);
  int glowing = 0;
  for (const DrawItem& item : list.items) {
    glowing += item.glows;
    EXPECT_FALSE(item.bounds.empty());
  }
  EXPECT_EQ(glowing, 1) << "the sphere, not the point";
  EXPECT_EQ(list.lights.size(), 2u);
}

TEST(SuggestAmbientTest, GrowsWithTheLightThereIs) {
  EXPECT_EQ(SuggestAmbient(*Scene::Empty("dark")), Vec3(1)) << "else nothing could be seen";
  const auto lit = [](float intensity) {
    const AreaLight sun = {.id = "sun", .shape = DistantLight{.irradiance = {intensity, 0, 0}}};
    return SuggestAmbient(**Scene::Empty("s")->Apply({.upsert_lights = {sun}}));
  };
  EXPECT_GT(lit(1).x, 0);
  EXPECT_LT(lit(1).x, 0.1f) << "far below 1/π, which the sun gives";
  EXPECT_EQ(lit(1).y, 0);
  EXPECT_FLOAT_EQ(lit(8).x, 8 * lit(1).x);
}

}  // namespace
}  // namespace penumbra
