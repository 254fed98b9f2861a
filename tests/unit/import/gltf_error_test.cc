// What damaged documents get: a code and the name of the field.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/import/gltf_file.h"
#include "tests/unit/import/temp_folder.h"

namespace penumbra {
namespace {

using absl::StatusCode;
using nlohmann::json;
using testing::HasSubstr;

GltfFile Square() {
  GltfFile file;
  file.AddTriangles(UnitSquare(), SquareIndices());
  file.document["nodes"] = json::parse(R"([{"mesh": 0}])");
  return file;
}

struct Damage {
  const char* pointer;  // what to set, a JSON pointer
  const char* value;    // JSON, or nothing to take it out
  StatusCode code;
  const char* fragment;
};

class GltfErrors : public testing::TestWithParam<Damage> {};

TEST_P(GltfErrors, NameTheField) {
  GltfFile file = Square();
  const json::json_pointer pointer(GetParam().pointer);
  if (GetParam().value == nullptr) {
    file.document.at(pointer.parent_pointer()).erase(pointer.back());
  } else {
    file.document[pointer] = json::parse(GetParam().value);
  }
  const auto scene = file.Import();
  EXPECT_EQ(scene.status().code(), GetParam().code) << scene.status();
  EXPECT_THAT(std::string(scene.status().message()), HasSubstr(GetParam().fragment));
}

constexpr StatusCode kBad = StatusCode::kInvalidArgument;

INSTANTIATE_TEST_SUITE_P(
    Document, GltfErrors,
    testing::Values(
        Damage{"/asset", nullptr, kBad, "test.gltf: asset: found nothing, need an object"},
        Damage{"/asset/version", "\"1.0\"", StatusCode::kUnimplemented, "asset.version: found"},
        Damage{"/extensionsRequired", R"(["ACME_mesh"])", StatusCode::kUnimplemented,
               "extensionsRequired[0]: found \"ACME_mesh\""},
        Damage{"/nodes/0/mesh", "4", kBad, "nodes[0].mesh: found 4, need an index < 1"},
        Damage{"/nodes/0/mesh", "-1", kBad, "nodes[0].mesh: found -1"},
        Damage{"/nodes/0/mesh", "0.5", kBad, "nodes[0].mesh: found 0.5"},
        Damage{"/nodes/0/children", "[0]", kBad, "nodes[0].children: found a node below itself"},
        Damage{"/nodes/0/rotation", "[0,0,0,0]", kBad, "nodes[0].rotation: found length 0"},
        Damage{"/nodes/0/scale", "[1,1]", kBad, "nodes[0].scale: found an array of 2"},
        Damage{"/nodes/0/translation", "[1e300,0,0]", kBad, "nodes[0]: found a transform"},
        Damage{"/nodes/0/matrix", "[1,0,0,1,0,1,0,0,0,0,1,0,0,0,0,1]", kBad,
               "nodes[0].matrix[3]: found 1, need 0"},
        Damage{"/meshes/0/primitives/0/attributes", nullptr, kBad,
               "meshes[0].primitives[0].attributes: found nothing"},
        Damage{"/meshes/0/primitives/0/mode", "7", kBad, "primitives[0].mode: found 7"},
        Damage{"/meshes/0/primitives/0/indices", "0", kBad, "accessors[0].componentType"},
        Damage{"/meshes/0/primitives/0/attributes/POSITION", "1", kBad, "accessors[1].type"},
        Damage{"/accessors/0/bufferView", "9", kBad, "accessors[0].bufferView: found 9"},
        Damage{"/accessors/0/count", "400", kBad, "accessors[0].count: found 400 elements"},
        Damage{"/accessors/0/count", "2147483647", StatusCode::kResourceExhausted,
               "accessors[0].count: found 2147483647"},
        Damage{"/accessors/0/count", "3", kBad, "meshes[0].primitives[0].indices[5]"},
        Damage{"/accessors/0/componentType", "5124", kBad, "accessors[0].componentType"},
        Damage{"/accessors/0/byteOffset", "4294967295", kBad, "accessors[0].count"},
        Damage{"/bufferViews/0/byteLength", "1000000", kBad, "bufferViews[0].byteLength"},
        Damage{"/bufferViews/0/byteOffset", "18446744073709551615", kBad,
               "bufferViews[0].byteOffset: found"},
        Damage{"/bufferViews/0/byteStride", "4", kBad, "bufferViews[0].byteStride: found 4"}));

absl::Status ImportStatus(std::string_view text) { return ImportBytes("x.gltf", text).status(); }

TEST(GltfErrorsOfText, BrokenJsonNamesItsPlace) {
  const absl::Status status = ImportStatus("{\"asset\": ");
  EXPECT_EQ(status.code(), kBad);
  EXPECT_THAT(std::string(status.message()), HasSubstr("line 1"));
}

TEST(GltfErrorsOfText, DeepNestingIsRefusedWithoutRecursion) {
  const std::string deep(1'000'000, '[');
  const absl::Status status = ImportStatus("{\"extras\": " + deep);
  EXPECT_EQ(status.code(), kBad);
  EXPECT_THAT(std::string(status.message()), HasSubstr("nested"));
}

TEST(GltfErrorsOfText, MoreValuesThanAnySceneHasAreRefusedBeforeTheyAreBuilt) {
  const absl::Status status = ImportStatus("{\"extras\": [" + std::string(17'000'000, ',') + "]}");
  EXPECT_EQ(status.code(), StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(status.message()), HasSubstr("json: found 17000002 values"));
}

TEST(GltfErrorsOfText, ALongChainOfNodesIsRefused) {
  GltfFile file;
  for (int i = 0; i < 100'000; ++i) file.document["nodes"].push_back({{"children", {i + 1}}});
  file.document["nodes"].push_back(json::object());
  const absl::Status status = ImportStatus(file.Text());
  EXPECT_EQ(status.code(), kBad);
  EXPECT_THAT(std::string(status.message()), HasSubstr("found depth 4097"));
}

TEST(GltfErrorsOfText, NonFinitePositionsAreRefused) {
  GltfFile file;
  file.AddTriangles({{0, 0, 0}, {1, 0, std::numeric_limits<float>::quiet_NaN()}, {0, 1, 0}}, {});
  file.document["nodes"] = json::parse(R"([{"mesh": 0}])");
  const absl::Status status = ImportStatus(file.Text());
  EXPECT_EQ(status.code(), kBad);
  EXPECT_THAT(std::string(status.message()), HasSubstr("meshes[0].primitives[0].positions[1]"));
}

TEST(GltfErrorsOfText, LimitsOfASceneAreKept) {
  GltfFile file = Square();
  for (int i = 0; i < 10; ++i) file.document["nodes"].push_back({{"mesh", 0}});
  const TempFolder folder;
  const auto scene = ImportScene(folder.Write("a.gltf", file.Text()), {.max_instances = 4});
  EXPECT_EQ(scene.status().code(), StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(scene.status().message()), HasSubstr("need <= 4"));
}

}  // namespace
}  // namespace penumbra
