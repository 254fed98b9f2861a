// Lights of glTF files: places, directions, sides, and the unit convention of docs/scene-files.md.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/import/gltf_file.h"
#include "tests/unit/import/temp_folder.h"

namespace penumbra {
namespace {

using nlohmann::json;
using testing::HasSubstr;

constexpr float kTolerance = 1e-5f;

void ExpectNear(Vec3 found, Vec3 expected) {
  EXPECT_LT(glm::distance(found, expected), kTolerance)
      << found.x << " " << found.y << " " << found.z;
}

// One light of `extension`, on a node turned so that its −z looks down, at (1, 5, 2).
AreaLight Imported(const char* extension, const char* light, double scale = 1.0) {
  GltfFile file;
  file.document["extensions"][extension]["lights"] = json::array({json::parse(light)});
  file.document["nodes"] = json::parse(R"([{"name": "lamp", "translation": [1, 5, 2],
      "rotation": [-0.70710678, 0, 0, 0.70710678]}])");
  file.document["nodes"][0]["scale"] = {scale, scale, scale};
  file.document["nodes"][0]["extensions"][extension]["light"] = 0;
  const auto scene = file.Import();
  EXPECT_TRUE(scene.ok()) << scene.status();
  return scene.ok() ? LightOf(*scene, "lamp") : AreaLight{};
}

TEST(PunctualLights, PointKeepsItsCandelas) {
  const AreaLight light =
      Imported("KHR_lights_punctual", R"({"type": "point", "intensity": 6, "color": [1, 0.5, 0]})");
  const auto& point = std::get<PointLight>(light.shape);
  ExpectNear(point.position, {1, 5, 2});
  ExpectNear(point.intensity, {6, 3, 0});
}

TEST(PunctualLights, SpotShinesAlongMinusZ) {
  const AreaLight light =
      Imported("KHR_lights_punctual",
               R"({"type": "spot", "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.7}})");
  const auto& spot = std::get<SpotLight>(light.shape);
  ExpectNear(glm::normalize(spot.direction), {0, -1, 0});
  EXPECT_FLOAT_EQ(spot.inner_angle, 0.2f);
  EXPECT_FLOAT_EQ(spot.outer_angle, 0.7f);
}

TEST(PunctualLights, DirectionalIsTheSun) {
  const AreaLight light =
      Imported("KHR_lights_punctual", R"({"type": "directional", "intensity": 3})", 4.0);
  const auto& sun = std::get<DistantLight>(light.shape);
  ExpectNear(glm::normalize(sun.to_light), {0, 1, 0});
  ExpectNear(sun.irradiance, {3, 3, 3});
  EXPECT_FLOAT_EQ(sun.angular_diameter, 0.00925f);
}

TEST(AreaLights, RectangleIsCentredOneSidedAndScaled) {
  const AreaLight light =
      Imported("EXT_lights_area",
               R"({"type": "rect", "size": 0.5, "rect": {"aspect": 3}, "intensity": 40})", 2.0);
  const auto& rectangle = std::get<RectangleLight>(light.shape);
  ExpectNear(rectangle.corner + 0.5f * (rectangle.edge_u + rectangle.edge_v), {1, 5, 2});
  EXPECT_NEAR(glm::length(rectangle.edge_u), 3.0f, kTolerance);  // along the node's x
  EXPECT_NEAR(glm::length(rectangle.edge_v), 1.0f, kTolerance);
  ExpectNear(glm::normalize(glm::cross(rectangle.edge_u, rectangle.edge_v)), {0, -1, 0});
  ExpectNear(rectangle.radiance, Vec3(40));
  EXPECT_FALSE(rectangle.two_sided);
}

TEST(AreaLights, DiskHasHalfItsSizeAsRadius) {
  const AreaLight light = Imported("EXT_lights_area", R"({"type": "disk", "size": 0.5})");
  const auto& disk = std::get<DiskLight>(light.shape);
  EXPECT_FLOAT_EQ(disk.radius, 0.25f);
  ExpectNear(glm::normalize(disk.normal), {0, -1, 0});
  ExpectNear(disk.radiance, Vec3(1000));  // the extension's default
}

// A glowing square, front towards +z, as node "panel".
ImportedScene Panel(const json& material, const json& node) {
  GltfFile file;
  file.AddTriangles(UnitSquare(), SquareIndices());
  file.document["meshes"][0]["primitives"][0]["material"] = 0;
  file.document["materials"] = json::array({material});
  file.document["nodes"] = json::array({node});
  file.document["nodes"][0]["mesh"] = 0;
  file.document["nodes"][0]["name"] = "panel";
  const auto scene = file.Import();
  EXPECT_TRUE(scene.ok()) << scene.status();
  return scene.ok() ? *scene : ImportedScene{};
}

json Glow() {
  return json::parse(R"({"emissiveFactor": [1, 0.5, 0.25], "extensions":
      {"KHR_materials_emissive_strength": {"emissiveStrength": 8}}})");
}

TEST(EmissiveSurfaces, AFlatOneIsALightAndNeitherCastsNorReceives) {
  const ImportedScene scene = Panel(Glow(), json::parse(R"({"scale": [2, 3, 1]})"));
  const auto light = std::get<RectangleLight>(LightOf(scene, "panel").shape);
  ExpectNear(light.radiance, {8, 4, 2});
  EXPECT_FALSE(light.two_sided);
  ExpectNear(glm::cross(light.edge_u, light.edge_v), {0, 0, 6});
  EXPECT_FALSE(InstanceOf(scene, "panel").casts);
  EXPECT_FALSE(InstanceOf(scene, "panel").receives);
}

TEST(EmissiveSurfaces, AMirrorDoesNotTurnThemOver) {
  const ImportedScene scene = Panel(Glow(), json::parse(R"({"scale": [-1, 1, 1]})"));
  const auto light = std::get<RectangleLight>(LightOf(scene, "panel").shape);
  ExpectNear(glm::cross(light.edge_u, light.edge_v), {0, 0, 1});
}

TEST(EmissiveSurfaces, DoubleSidedOnesShineBothWays) {
  json glow = Glow();
  glow["doubleSided"] = true;
  const ImportedScene scene = Panel(glow, json::object());
  EXPECT_TRUE(std::get<RectangleLight>(LightOf(scene, "panel").shape).two_sided);
}

TEST(EmissiveSurfaces, OtherShapesAreNoLightAndSaySo) {
  GltfFile file;
  file.AddTriangles({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {});
  file.document["meshes"][0]["primitives"][0]["material"] = 0;
  file.document["materials"] = json::array({Glow()});
  file.document["nodes"] = json::parse(R"([{"mesh": 0}])");
  const auto scene = file.Import();
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_TRUE(scene->lights.empty());
  EXPECT_TRUE(scene->instances[0].casts);
  EXPECT_TRUE(scene->instances[0].receives);
  EXPECT_THAT(scene->warnings, testing::Contains(HasSubstr("node0: glows")));
}

}  // namespace
}  // namespace penumbra
