// Component types, strides and sparse accessors, by the positions that come out.
#include <gtest/gtest.h>

#include "tests/unit/import/gltf_file.h"
#include "tests/unit/import/temp_folder.h"

namespace penumbra {
namespace {

using nlohmann::json;

// A triangle whose positions are accessor 0 of `file`.
Instance Imported(GltfFile& file) {
  file.document["meshes"] = json::parse(R"([{"primitives": [{"attributes": {"POSITION": 0}}]}])");
  file.document["nodes"] = json::parse(R"([{"mesh": 0}])");
  const auto scene = file.Import();
  EXPECT_TRUE(scene.ok()) << scene.status();
  return scene.ok() ? InstanceOf(*scene, "node0") : Instance{.mesh = Mesh::Create({}).value()};
}

template <typename T>
Instance WithComponents(std::vector<T> values, int component_type, bool normalized) {
  GltfFile file;
  const int view = file.AddView(values.data(), values.size() * sizeof(T));
  file.document["accessors"] = {{{"bufferView", view},
                                 {"componentType", component_type},
                                 {"normalized", normalized},
                                 {"type", "VEC3"},
                                 {"count", 3}}};
  return Imported(file);
}

TEST(Accessors, IntegersKeepTheirValueUnlessNormalised) {
  EXPECT_EQ(WorldVertex(WithComponents<int8_t>({-128, 127, 0, 0, 0, 0, 1, 1, 1}, 5120, false), 0),
            Vec3(-128, 127, 0));
  EXPECT_EQ(WorldVertex(WithComponents<uint16_t>({65535, 1, 0, 0, 0, 0, 1, 1, 1}, 5123, false), 0),
            Vec3(65535, 1, 0));
}

TEST(Accessors, NormalisedIntegersReachBothEnds) {
  EXPECT_EQ(WorldVertex(WithComponents<int8_t>({-128, 127, -127, 0, 0, 0, 1, 1, 1}, 5120, true), 0),
            Vec3(-1, 1, -1));
  EXPECT_EQ(WorldVertex(WithComponents<uint8_t>({255, 0, 51, 0, 0, 0, 1, 1, 1}, 5121, true), 0),
            Vec3(1, 0, 0.2f));
  EXPECT_EQ(
      WorldVertex(WithComponents<int16_t>({-32768, 32767, 0, 0, 0, 0, 1, 1, 1}, 5122, true), 0),
      Vec3(-1, 1, 0));
  EXPECT_EQ(
      WorldVertex(WithComponents<uint16_t>({65535, 0, 13107, 0, 0, 0, 1, 1, 1}, 5123, true), 0),
      Vec3(1, 0, 0.2f));
}

TEST(Accessors, StridesAndOffsetsAreKept) {
  GltfFile file;
  const std::vector<float> interleaved = {9, 1, 2, 3, 9, 4, 5, 6, 9, 7, 8, 9};
  file.AddView(interleaved.data(), interleaved.size() * sizeof(float));
  file.document["bufferViews"][0]["byteStride"] = 16;
  file.document["accessors"] = {{{"bufferView", 0},
                                 {"byteOffset", 4},
                                 {"componentType", 5126},
                                 {"type", "VEC3"},
                                 {"count", 3}}};
  const Instance instance = Imported(file);
  EXPECT_EQ(WorldVertex(instance, 0), Vec3(1, 2, 3));
  EXPECT_EQ(WorldVertex(instance, 2), Vec3(7, 8, 9));
}

TEST(Accessors, SparseValuesReplaceDenseOnes) {
  for (const bool with_base : {true, false}) {
    GltfFile file;
    file.AddFloats({1, 1, 1, 2, 2, 2, 3, 3, 3}, "VEC3");
    const uint16_t index = 1;
    const std::vector<float> value = {7, 8, 9};
    const int indices = file.AddView(&index, sizeof(index));
    const int values = file.AddView(value.data(), 12);
    json& accessor = file.document["accessors"][0];
    accessor["sparse"] = {{"count", 1},
                          {"indices", {{"bufferView", indices}, {"componentType", 5123}}},
                          {"values", {{"bufferView", values}}}};
    if (!with_base) accessor.erase("bufferView");
    const Instance instance = Imported(file);
    EXPECT_EQ(WorldVertex(instance, 1), Vec3(7, 8, 9));
    EXPECT_EQ(WorldVertex(instance, 2), with_base ? Vec3(3) : Vec3(0));
  }
}

TEST(Accessors, AllIndexTypesAreRead) {
  for (const int type : {5121, 5123, 5125}) {
    GltfFile file;
    file.AddTriangles(UnitSquare(), {});
    const std::vector<uint8_t> small = {1, 2, 3};
    const std::vector<uint16_t> medium = {1, 2, 3};
    const std::vector<uint32_t> large = {1, 2, 3};
    const int view = type == 5121   ? file.AddView(small.data(), 3)
                     : type == 5123 ? file.AddView(medium.data(), 6)
                                    : file.AddView(large.data(), 12);
    file.document["accessors"].push_back(
        {{"bufferView", view}, {"componentType", type}, {"type", "SCALAR"}, {"count", 3}});
    file.document["meshes"][0]["primitives"][0]["indices"] = 1;
    file.document["nodes"] = json::parse(R"([{"mesh": 0}])");
    const auto scene = file.Import();
    ASSERT_TRUE(scene.ok()) << scene.status();
    const auto indices = scene->instances[0].mesh->indices();
    EXPECT_EQ(std::vector<uint32_t>(indices.begin(), indices.end()), large);
  }
}

}  // namespace
}  // namespace penumbra
