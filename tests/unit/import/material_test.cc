// Colours, masks and see-through surfaces of glTF files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "absl/strings/escaping.h"
#include "client/import/gltf/materials.h"
#include "client/import/image.h"
#include "tests/unit/import/gltf_file.h"
#include "tests/unit/import/temp_folder.h"

namespace penumbra {
namespace {

using nlohmann::json;
using testing::HasSubstr;

// 2×2 RGBA as PNG: (255,0,0,255) (0,255,0,0) above (0,0,255,128) (255,255,255,255).
constexpr char kPicture[] =
    "iVBORw0KGgoAAAANSUhEUgAAAAIAAAACCAYAAABytg0kAAAAFUlE"
    "QVR42mP4z8DwHwhB4H/DfyAAAD1XCHkixQx7AAAAAElFTkSuQmCC";

GltfFile Square(const char* material) {
  GltfFile file;
  file.AddTriangles(UnitSquare(), SquareIndices());
  json& primitive = file.document["meshes"][0]["primitives"][0];
  primitive["material"] = 0;
  primitive["attributes"]["TEXCOORD_0"] = file.AddFloats({0, 0, 1, 0, 1, 1, 0, 1}, "VEC2");
  file.document["materials"] = json::array({json::parse(material)});
  file.document["textures"] = json::parse(R"([{"source": 0}])");
  file.document["images"] = {{{"uri", std::string("data:image/png;base64,") + kPicture}}};
  file.document["nodes"] = json::parse(R"([{"mesh": 0, "name": "leaf"}])");
  return file;
}

ImportedScene Imported(const GltfFile& file) {
  const auto scene = file.Import();
  EXPECT_TRUE(scene.ok()) << scene.status();
  return scene.ok() ? *scene : ImportedScene{};
}

TEST(Materials, ColourIsFactorTimesMeanLinearTexture) {
  const ImportedScene scene = Imported(Square(R"({"pbrMetallicRoughness":
      {"baseColorFactor": [0.5, 1, 1, 1], "baseColorTexture": {"index": 0}}})"));
  // Weights 255, 0, 128, 255: red from two of them, green from one, blue from two.
  const float all = 255 + 128 + 255;
  const Vec3 color = InstanceOf(scene, "leaf").color;
  EXPECT_NEAR(color.x, 0.5f * (255 + 255) / all, 1e-5f);
  EXPECT_NEAR(color.y, 255 / all, 1e-5f);
  EXPECT_NEAR(color.z, (128 + 255) / all, 1e-5f);
}

TEST(Materials, MeansAreTakenInLinearLight) {
  const Image grey{.width = 1, .height = 2, .rgba = {0, 0, 0, 255, 188, 188, 188, 255}};
  // sRGB 188 is 0.5029 in linear light; its half is not what sRGB 94 is.
  EXPECT_NEAR(MeanLinearColor(grey).x, 0.25144f, 1e-4f);
}

TEST(Materials, OpaqueMaterialsIgnoreOpacity) {
  const Instance leaf = InstanceOf(
      Imported(Square(R"({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}})")), "leaf");
  EXPECT_EQ(leaf.alpha_mask, nullptr);
  EXPECT_TRUE(leaf.mesh->uvs().empty());
}

TEST(Materials, MasksKeepTheTextureAndMoveTheCutoff) {
  const Instance leaf = InstanceOf(
      Imported(Square(R"({"alphaMode": "MASK", "alphaCutoff": 0.4, "pbrMetallicRoughness":
          {"baseColorFactor": [1, 1, 1, 0.8], "baseColorTexture": {"index": 0}}})")),
      "leaf");
  ASSERT_NE(leaf.alpha_mask, nullptr);
  EXPECT_FLOAT_EQ(leaf.alpha_cutoff, 0.5f);
  // Row 0 is the picture's top, at v = 0.
  EXPECT_EQ(leaf.alpha_mask->At({0.25f, 0.25f}), 1.0f);
  EXPECT_EQ(leaf.alpha_mask->At({0.75f, 0.25f}), 0.0f);
  EXPECT_NEAR(leaf.alpha_mask->At({0.25f, 0.75f}), 128 / 255.0f, 1e-6f);
  ASSERT_EQ(leaf.mesh->uvs().size(), 4u);
  EXPECT_EQ(leaf.mesh->uvs()[2], Vec2(1, 1));
}

TEST(Materials, SurfacesCutAwayEverywhereAreLeftOut) {
  const ImportedScene scene = Imported(Square(
      R"({"alphaMode": "MASK", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.3]}})"));
  EXPECT_TRUE(scene.instances.empty());
  EXPECT_THAT(scene.warnings, testing::Contains(HasSubstr("materials[0]: cut away")));
}

TEST(Materials, ClearPanesStayAndCastNoShadow) {
  for (const char* material :
       {R"({"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.3]}})",
        R"({"extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.9}}})"}) {
    const ImportedScene scene = Imported(Square(material));
    EXPECT_FALSE(InstanceOf(scene, "leaf").casts) << material;
    EXPECT_FALSE(scene.warnings.empty());
  }
}

TEST(Materials, UnreadableTexturesWarnAndCountAsWhite) {
  GltfFile file = Square(R"({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}})");
  for (const char* uri : {"missing.png", "../up.png", "data:image/png;base64,AAAA"}) {
    file.document["images"][0]["uri"] = uri;
    const ImportedScene scene = Imported(file);
    EXPECT_EQ(InstanceOf(scene, "leaf").color, Vec3(1)) << uri;
    EXPECT_THAT(scene.warnings, testing::Contains(HasSubstr("images[0]"))) << uri;
  }
}

TEST(TextureCoordinates, ScaleThenTurnThenMove) {
  // The extension's matrix for a quarter turn maps (1, 0) to (0, −1).
  const gltf::TextureCoordinates quarter{
      .offset = {10, 20}, .rotation = std::numbers::pi_v<float> / 2, .scale = {2, 3}};
  EXPECT_LT(glm::distance(quarter.Apply({1, 0}), Vec2(10, 18)), 1e-5f);
  EXPECT_LT(glm::distance(quarter.Apply({0, 1}), Vec2(13, 20)), 1e-5f);
}

TEST(Images, A21HeadersThatPromiseTooMuchAreRefusedBeforeDecoding) {
  std::string bomb;
  ASSERT_TRUE(absl::Base64Unescape(kPicture, &bomb));
  // Width and height of the header, big-endian, at byte 16: 16,384 × 16,384.
  bomb.replace(16, 8, std::string("\0\0\x40\0\0\0\x40\0", 8));
  const auto image = DecodeImage(std::as_bytes(std::span(bomb)), "images[3]");
  EXPECT_EQ(image.status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(image.status().message()), HasSubstr("images[3]: found 16384×16384"));
}

}  // namespace
}  // namespace penumbra
