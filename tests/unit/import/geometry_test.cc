// Primitive modes, morphs, and packed primitives.
#include "client/import/gltf/geometry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/import/gltf_file.h"
#include "tests/unit/import/temp_folder.h"

namespace penumbra {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(ToTriangles, StripsTurnEveryOtherTriangle) {
  EXPECT_THAT(gltf::ToTriangles({7, 8, 9, 10, 11}, 5), ElementsAre(7, 8, 9, 8, 10, 9, 9, 10, 11));
}

TEST(ToTriangles, FansTurnAboutTheFirst) {
  EXPECT_THAT(gltf::ToTriangles({7, 8, 9, 10}, 6), ElementsAre(8, 9, 7, 9, 10, 7));
}

TEST(ToTriangles, WhatMakesNoTriangleIsLeftOut) {
  EXPECT_THAT(gltf::ToTriangles({1, 2, 3, 4, 5}, 4), ElementsAre(1, 2, 3));
  EXPECT_TRUE(gltf::ToTriangles({1, 2}, 5).empty());
  EXPECT_TRUE(gltf::ToTriangles({}, 6).empty());
}

TEST(Geometry, StripsAndListsOfOneSquareFaceTheSameWay) {
  for (const auto& [mode, corners] : {std::pair{4, std::vector<uint16_t>{0, 1, 2, 0, 2, 3}},
                                      std::pair{5, std::vector<uint16_t>{0, 1, 3, 2}},
                                      std::pair{6, std::vector<uint16_t>{0, 1, 2, 3}}}) {
    GltfFile file;
    file.AddTriangles(UnitSquare(), corners);
    file.document["meshes"][0]["primitives"][0]["mode"] = mode;
    file.document["nodes"] = json::parse(R"([{"mesh": 0}])");
    const auto scene = file.Import();
    ASSERT_TRUE(scene.ok()) << scene.status();
    const Mesh& mesh = *InstanceOf(*scene, "node0").mesh;
    ASSERT_EQ(mesh.triangle_count(), 2u);
    for (size_t t = 0; t < 2; ++t) {
      const auto p = [&](size_t k) { return mesh.positions()[mesh.indices()[3 * t + k]]; };
      EXPECT_GT(glm::cross(p(1) - p(0), p(2) - p(0)).z, 0.9f) << "mode " << mode;
    }
  }
}

TEST(Geometry, PointsAndLinesAreLeftOutWithAWarning) {
  GltfFile file;
  file.AddTriangles(UnitSquare(), {});
  file.document["meshes"][0]["primitives"][0]["mode"] = 1;
  file.document["nodes"] = json::parse(R"([{"mesh": 0}])");
  const auto scene = file.Import();
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_TRUE(scene->instances.empty());
  EXPECT_THAT(scene->warnings, testing::Contains(HasSubstr("meshes[0].primitives[0]")));
}

TEST(Geometry, PrimitivesOfOneMeshAreInstancesOfTheirOwn) {
  GltfFile file;
  file.AddTriangles(UnitSquare(), SquareIndices());
  json& primitives = file.document["meshes"][0]["primitives"];
  primitives.push_back(primitives[0]);
  file.document["nodes"] = json::parse(R"([{"mesh": 0, "name": "crate"}])");
  const auto scene = file.Import();
  ASSERT_TRUE(scene.ok()) << scene.status();
  // The same accessors, so the same mesh.
  EXPECT_EQ(InstanceOf(*scene, "crate.0").mesh.get(), InstanceOf(*scene, "crate.1").mesh.get());
}

TEST(Geometry, MorphsAddTheirWeightedOffsets) {
  GltfFile file;
  file.AddTriangles({{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {});
  const int up = file.AddFloats({0, 4, 0, 0, 4, 0, 0, 4, 0}, "VEC3");
  file.document["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", up}}};
  file.document["meshes"][0]["weights"] = {0.25};
  file.document["nodes"] = json::parse(R"([{"mesh": 0, "name": "of mesh"},
                                           {"mesh": 0, "name": "of node", "weights": [0.5]}])");
  const auto scene = file.Import();
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ(WorldVertex(InstanceOf(*scene, "of_mesh"), 0), Vec3(1, 1, 0));
  EXPECT_EQ(WorldVertex(InstanceOf(*scene, "of_node"), 0), Vec3(1, 2, 0));
}

// Volume inside a closed mesh whose faces turn outwards.
double Volume(const Instance& instance) {
  double six_volumes = 0.0;
  const auto indices = instance.mesh->indices();
  for (size_t i = 0; i < indices.size(); i += 3) {
    six_volumes += glm::dot(DVec3(WorldVertex(instance, indices[i])),
                            glm::cross(DVec3(WorldVertex(instance, indices[i + 1])),
                                       DVec3(WorldVertex(instance, indices[i + 2]))));
  }
  return six_volumes / 6.0;
}

// The corpus' packed boxes are [−½, ½] × [0, 1] × [−½, ½].
TEST(Geometry, PackedPrimitivesUnpack) {
  for (const char* name : {"draco.glb", "meshopt.glb"}) {
    const auto scene = ImportScene(std::filesystem::path(PENUMBRA_CORPUS) / name);
    ASSERT_TRUE(scene.ok()) << scene.status();
    const Instance box = InstanceOf(*scene, "box");
    EXPECT_EQ(box.mesh->triangle_count(), 12u) << name;
    // Draco quantised to 11 bits.
    EXPECT_NEAR(Volume(box), 1.0, 2e-3) << name;
    EXPECT_NEAR(Bounds(*scene).min.y, 0.0f, 1e-3f) << name;
    EXPECT_NEAR(Bounds(*scene).max.x, 0.5f, 1e-3f) << name;
  }
}

}  // namespace
}  // namespace penumbra
