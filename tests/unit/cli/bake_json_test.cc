#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "client/cli/bake_files.h"
#include "client/cli/light_json.h"

namespace penumbra {
namespace {

using Json = nlohmann::json;

Artifact SmallArtifact() {
  Artifact artifact;
  artifact.header = {
      .scene_id = "bake-1",
      .revision = 3,
      .technique = "soft_texture",
      .light_id = "lamp",
      .receiver_id = "floor",
      .parameters = {{"samples", "2"}, {"seed", "18446744073709551615"}, {"radiance", "false"}},
      .light_samples = {{.point = {0.1f, 2, 0.3f}, .weight = 0.5f},
                        {.point = {0, 1, 0}, .at_infinity = true, .weight = 0.5f}},
      .timings_ms = {{"clip", 0.25}}};
  SoftShadowTexture texture;
  texture.receiver = {.patch = {Vec3(-1, 0, 1), Vec3(2, 0, 0), Vec3(0, 0, -2)},
                      .width = 2,
                      .height = 1,
                      .two_sided = false,
                      .reflectance = Vec3(0.5f)};
  texture.light = {.id = "lamp", .shape = SphereLight{.center = {0, 2, 0}, .radius = 0.1f}};
  texture.visibility = {.width = 2, .height = 1, .sample_count = 2, .counts = {0, 2}};
  artifact.payload = std::move(texture);
  return artifact;
}

Json Parsed() {
  const Artifact artifact = SmallArtifact();
  const BakeRecord record{
      .artifact = artifact, .scene = "dir/table.glb", .name = "floor.lamp", .wall_ms = 1.5};
  return Json::parse(BakeJson(record, 2.0f));
}

TEST(BakeJsonTest, HoldsAllThatIsNeededToComputeTheCountsAgain) {
  const Json json = Parsed();
  EXPECT_EQ(json["technique"], "soft_texture");
  EXPECT_EQ(json["parameters"]["samples"], 2);
  EXPECT_EQ(json["parameters"]["seed"], 18446744073709551615u);
  EXPECT_EQ(json["parameters"]["radiance"], false);
  EXPECT_EQ(json["scene"], "dir/table.glb");
  EXPECT_EQ(json["revision"], 3);
  const Json& receiver = json["receiver"];
  EXPECT_EQ(receiver["origin"], Json({-1.0, 0.0, 1.0}));
  EXPECT_EQ(receiver["edge_u"], Json({2.0, 0.0, 0.0}));
  EXPECT_EQ(receiver["edge_v"], Json({0.0, 0.0, -2.0}));
  EXPECT_EQ(receiver["width"], 2);
  EXPECT_EQ(receiver["height"], 1);
  EXPECT_EQ(receiver["two_sided"], false);
  EXPECT_EQ(json["timings_ms"]["clip"], 0.25);
  EXPECT_EQ(json["timings_ms"]["wall"], 1.5);
  EXPECT_EQ(json["files"]["exr"], "floor.lamp.exr");
  EXPECT_EQ(json["png"]["exposure"], 2.0);
}

TEST(BakeJsonTest, SamplesKeepEveryBit) {
  const Json json = Parsed();
  ASSERT_EQ(json["light_samples"].size(), 2u);
  const Json& point = json["light_samples"][0];
  EXPECT_EQ(static_cast<float>(point["position"][0].get<double>()), 0.1f);
  EXPECT_EQ(static_cast<float>(point["position"][2].get<double>()), 0.3f);
  EXPECT_EQ(point["weight"], 0.5);
  EXPECT_FALSE(point.contains("direction"));
  EXPECT_EQ(json["light_samples"][1]["direction"], Json({0.0, 1.0, 0.0}));
  EXPECT_FALSE(json["light_samples"][1].contains("position"));
}

// Each float in the fewest digits that mean it.
TEST(BakeJsonTest, NumbersAreShort) {
  const Artifact artifact = SmallArtifact();
  const std::string text = BakeJson(
      {.artifact = artifact, .scene = "dir/table.glb", .name = "floor.lamp", .wall_ms = 1.5}, 0.7f);
  for (const char* number : {"0.1,", "0.3\n", "\"radius\": 0.1", "\"exposure\": 0.7\n"}) {
    EXPECT_NE(text.find(number), std::string::npos) << number << " in " << text;
  }
  EXPECT_EQ(text.find("0.10000"), std::string::npos) << text;
}

TEST(LightJsonTest, NamesEveryField) {
  const auto type_of = [](LightShape shape) {
    return LightToJson({.id = "l", .shape = std::move(shape)});
  };
  EXPECT_EQ(type_of(RectangleLight{.edge_u = {3, 0, 0}})["edge_u"], Json({3.0, 0.0, 0.0}));
  EXPECT_EQ(type_of(DiskLight{.radius = 2})["radius"], 2.0);
  EXPECT_EQ(type_of(SphereLight{})["type"], "sphere");
  EXPECT_EQ(type_of(PointLight{.intensity = Vec3(4)})["intensity"], Json({4.0, 4.0, 4.0}));
  EXPECT_EQ(type_of(SpotLight{.inner_angle = 0.5f})["inner_angle"], 0.5);
  EXPECT_EQ(type_of(DistantLight{.angular_diameter = 0.25f})["angular_diameter"], 0.25);
}

}  // namespace
}  // namespace penumbra
