#include "tests/unit/import/gltf_file.h"

#include <numeric>

#include "absl/strings/escaping.h"
#include "tests/unit/import/temp_folder.h"

namespace penumbra {
namespace {

int ComponentsOf(const std::string& type) {
  return type == "SCALAR" ? 1 : type == "MAT4" ? 16 : type.back() - '0';
}

void AppendU32(std::string& out, uint32_t value) {
  for (int shift = 0; shift < 32; shift += 8) out.push_back(static_cast<char>(value >> shift));
}

}  // namespace

GltfFile::GltfFile() {
  document["asset"]["version"] = "2.0";
  for (const char* key : {"bufferViews", "accessors", "meshes", "nodes"}) {
    document[key] = nlohmann::json::array();
  }
}

int GltfFile::AddView(const void* data, size_t size) {
  bytes.resize((bytes.size() + 3) / 4 * 4);
  document["bufferViews"].push_back(
      {{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", size}});
  bytes.append(static_cast<const char*>(data), size);
  return static_cast<int>(document["bufferViews"].size()) - 1;
}

int GltfFile::AddFloats(const std::vector<float>& values, const std::string& type) {
  const int view = AddView(values.data(), values.size() * sizeof(float));
  document["accessors"].push_back({{"bufferView", view},
                                   {"componentType", 5126},
                                   {"type", type},
                                   {"count", values.size() / ComponentsOf(type)}});
  return static_cast<int>(document["accessors"].size()) - 1;
}

int GltfFile::AddIndices(const std::vector<uint16_t>& values) {
  const int view = AddView(values.data(), values.size() * sizeof(uint16_t));
  document["accessors"].push_back({{"bufferView", view},
                                   {"componentType", 5123},
                                   {"type", "SCALAR"},
                                   {"count", values.size()}});
  return static_cast<int>(document["accessors"].size()) - 1;
}

int GltfFile::AddTriangles(const std::vector<Vec3>& positions,
                           const std::vector<uint16_t>& indices) {
  std::vector<float> numbers;
  for (const Vec3& p : positions) numbers.insert(numbers.end(), {p.x, p.y, p.z});
  nlohmann::json primitive;
  primitive["attributes"]["POSITION"] = AddFloats(numbers, "VEC3");
  if (!indices.empty()) primitive["indices"] = AddIndices(indices);
  document["meshes"].push_back({{"primitives", nlohmann::json::array({primitive})}});
  return static_cast<int>(document["meshes"].size()) - 1;
}

std::string GltfFile::Text() const {
  nlohmann::json whole = document;
  if (!bytes.empty()) {
    whole["buffers"] = {
        {{"byteLength", bytes.size()},
         {"uri", "data:application/octet-stream;base64," + absl::Base64Escape(bytes)}}};
  }
  return whole.dump();
}

std::string GltfFile::Glb() const {
  nlohmann::json whole = document;
  whole["buffers"] = {{{"byteLength", bytes.size()}}};
  std::string json = whole.dump(), bin = bytes;
  json.resize((json.size() + 3) / 4 * 4, ' ');
  bin.resize((bin.size() + 3) / 4 * 4);
  std::string out = "glTF";
  AppendU32(out, 2);
  AppendU32(out, static_cast<uint32_t>(12 + 8 + json.size() + 8 + bin.size()));
  AppendU32(out, static_cast<uint32_t>(json.size()));
  out += "JSON" + json;
  AppendU32(out, static_cast<uint32_t>(bin.size()));
  out += std::string("BIN\0", 4) + bin;
  return out;
}

absl::StatusOr<ImportedScene> GltfFile::Import() const { return ImportBytes("test.gltf", Text()); }

std::vector<Vec3> UnitSquare() { return {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}; }

std::vector<uint16_t> SquareIndices() { return {0, 1, 2, 0, 2, 3}; }

}  // namespace penumbra
