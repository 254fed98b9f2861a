// Where nodes put their meshes, checked against positions worked out by hand.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/unit/import/gltf_file.h"
#include "tests/unit/import/temp_folder.h"

namespace penumbra {
namespace {

using nlohmann::json;
using testing::HasSubstr;

constexpr float kTolerance = 1e-5f;

GltfFile WithNodes(const char* nodes) {
  GltfFile file;
  file.AddTriangles({{1, 0, 0}, {0, 2, 0}, {0, 0, 3}}, {});
  file.document["nodes"] = json::parse(nodes);
  return file;
}

void ExpectNear(Vec3 found, Vec3 expected) {
  EXPECT_LT(glm::distance(found, expected), kTolerance)
      << found.x << " " << found.y << " " << found.z;
}

TEST(Nodes, TranslationRotationScaleApplyInThatOrder) {
  // A quarter turn about +y takes x to −z and z to x.
  const auto scene = WithNodes(R"([{"mesh": 0, "translation": [10, 20, 30], "scale": [2, 3, 4],
      "rotation": [0, 0.70710678, 0, 0.70710678]}])")
                         .Import();
  ASSERT_TRUE(scene.ok()) << scene.status();
  const Instance instance = InstanceOf(*scene, "node0");
  ExpectNear(WorldVertex(instance, 0), {10, 20, 28});
  ExpectNear(WorldVertex(instance, 1), {10, 26, 30});
  ExpectNear(WorldVertex(instance, 2), {22, 20, 30});
}

TEST(Nodes, MatricesAreColumnMajorAndParentsComeFirst) {
  // Child: x + 1. Parent: x and y change places, then + (0, 0, 5).
  const auto scene = WithNodes(R"([
      {"children": [1], "matrix": [0,1,0,0, 1,0,0,0, 0,0,1,0, 0,0,5,1]},
      {"mesh": 0, "translation": [1, 0, 0]}])")
                         .Import();
  ASSERT_TRUE(scene.ok()) << scene.status();
  ExpectNear(WorldVertex(InstanceOf(*scene, "node1"), 0), {0, 2, 5});
  ExpectNear(WorldVertex(InstanceOf(*scene, "node1"), 1), {2, 1, 5});
}

TEST(Nodes, NegativeAndZeroScalesArePassedOn) {
  const auto scene = WithNodes(R"([{"mesh": 0, "scale": [-1, 1, 1]},
                                   {"mesh": 0, "scale": [0, 0, 0]}])")
                         .Import();
  ASSERT_TRUE(scene.ok()) << scene.status();
  ExpectNear(WorldVertex(InstanceOf(*scene, "node0"), 0), {-1, 0, 0});
  ExpectNear(WorldVertex(InstanceOf(*scene, "node1"), 2), {0, 0, 0});
  EXPECT_TRUE(Scene::Empty("s")->Apply(ToSceneDelta(*scene)).ok());
}

TEST(Nodes, RotationsAreNormalisedWithAWarning) {
  const auto scene = WithNodes(R"([{"mesh": 0, "rotation": [0, 3, 0, 3]}])").Import();
  ASSERT_TRUE(scene.ok()) << scene.status();
  ExpectNear(WorldVertex(InstanceOf(*scene, "node0"), 0), {0, 0, -1});
  EXPECT_THAT(scene->warnings, testing::Contains(HasSubstr("nodes[0].rotation")));
}

TEST(Nodes, OneMeshIsSharedByItsInstances) {
  const auto scene = WithNodes(R"([{"mesh": 0, "name": "a"}, {"mesh": 0, "name": "a"}])").Import();
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ(InstanceOf(*scene, "a").mesh.get(), InstanceOf(*scene, "a-2").mesh.get());
}

TEST(Nodes, OnlyTheDefaultSceneIsRead) {
  GltfFile file = WithNodes(R"([{"mesh": 0, "name": "in"}, {"mesh": 0, "name": "out"}])");
  file.document["scenes"] = json::parse(R"([{"nodes": [1]}, {"nodes": [0]}])");
  file.document["scene"] = 1;
  const auto scene = file.Import();
  ASSERT_TRUE(scene.ok()) << scene.status();
  ASSERT_EQ(scene->instances.size(), 1u);
  EXPECT_EQ(scene->instances[0].id, "in");
}

TEST(Nodes, GpuInstancingPlacesEachElement) {
  GltfFile file = WithNodes(R"([{"mesh": 0, "name": "tile", "translation": [0, 0, 7]}])");
  const int translations = file.AddFloats({0, 0, 0, 5, 0, 0}, "VEC3");
  const int scales = file.AddFloats({1, 1, 1, 2, 2, 2}, "VEC3");
  file.document["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"TRANSLATION", translations}, {"SCALE", scales}};
  const auto scene = file.Import();
  ASSERT_TRUE(scene.ok()) << scene.status();
  ASSERT_EQ(scene->instances.size(), 2u);
  ExpectNear(WorldVertex(InstanceOf(*scene, "tile"), 0), {1, 0, 7});
  ExpectNear(WorldVertex(InstanceOf(*scene, "tile-2"), 0), {7, 0, 7});
  EXPECT_EQ(scene->instances[0].mesh.get(), scene->instances[1].mesh.get());
}

TEST(Nodes, CamerasLookAlongMinusZ) {
  GltfFile file = WithNodes(R"([{"camera": 0, "name": "eye", "translation": [1, 2, 3],
      "rotation": [0, 0.70710678, 0, 0.70710678], "scale": [2, 2, 2]}])");
  file.document["cameras"] =
      json::parse(R"([{"type": "perspective", "perspective": {"yfov": 0.6, "znear": 0.1}}])");
  const auto scene = file.Import();
  ASSERT_TRUE(scene.ok()) << scene.status();
  ASSERT_EQ(scene->cameras.size(), 1u);
  EXPECT_EQ(scene->cameras[0].id, "eye");
  EXPECT_FLOAT_EQ(scene->cameras[0].fov_y, 0.6f);
  ExpectNear(scene->cameras[0].position, {1, 2, 3});
  ExpectNear(scene->cameras[0].forward, {-1, 0, 0});
  ExpectNear(scene->cameras[0].up, {0, 1, 0});
}

TEST(Nodes, CamerasWithoutAnUprightAreLeftOut) {
  for (const char* node :
       {R"([{"camera": 0, "scale": [1, 0, 1]}])", R"([{"camera": 0, "scale": [1, 1, 1e-170]}])",
        R"([{"camera": 0, "matrix": [1,0,0,0, 0.07,0.14,0.21,0, 0.1,0.2,0.3,0, 0,0,0,1]}])"}) {
    GltfFile file = WithNodes(node);
    file.document["cameras"] =
        json::parse(R"([{"type": "perspective", "perspective": {"yfov": 0.6, "znear": 0.1}}])");
    const auto scene = file.Import();
    ASSERT_TRUE(scene.ok()) << scene.status();
    EXPECT_TRUE(scene->cameras.empty()) << node;
    EXPECT_THAT(scene->warnings, testing::Contains(HasSubstr("not a usable perspective"))) << node;
  }
}

TEST(Nodes, TextAndGlbAreTheSame) {
  const GltfFile file = WithNodes(R"([{"mesh": 0, "name": "x"}])");
  const auto text = ImportBytes("a.gltf", file.Text());
  const auto glb = ImportBytes("a.glb", file.Glb());
  ASSERT_TRUE(text.ok() && glb.ok()) << text.status() << glb.status();
  EXPECT_EQ(text->instances[0].mesh->id(), glb->instances[0].mesh->id());
  // The first bytes decide, not the extension.
  EXPECT_TRUE(ImportBytes("a.obj", file.Glb()).ok());
}

TEST(Nodes, SkinsBendIntoTheFilesPose) {
  // One joint, which lies at (0, 0, 4) where it was bound at the origin.
  GltfFile file = WithNodes(R"([{"mesh": 0, "skin": 0, "translation": [100, 0, 0]},
                                {"translation": [0, 0, 4]}])");
  const std::vector<uint8_t> joints(12, 0);
  const int view = file.AddView(joints.data(), joints.size());
  file.document["accessors"].push_back(
      {{"bufferView", view}, {"componentType", 5121}, {"type", "VEC4"}, {"count", 3}});
  json& attributes = file.document["meshes"][0]["primitives"][0]["attributes"];
  attributes["JOINTS_0"] = file.document["accessors"].size() - 1;
  attributes["WEIGHTS_0"] = file.AddFloats({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
  file.document["skins"] = json::parse(R"([{"joints": [1]}])");
  const auto scene = file.Import();
  ASSERT_TRUE(scene.ok()) << scene.status();
  // The node's own place does not count.
  ExpectNear(WorldVertex(InstanceOf(*scene, "node0"), 0), {1, 0, 4});
}

}  // namespace
}  // namespace penumbra
