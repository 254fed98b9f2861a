// Small glTF documents for tests.
//
//   GltfFile file;
//   file.AddTriangles({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {0, 1, 2});
//   file.document["nodes"] = json::parse(R"([{"mesh": 0}])");
//   auto scene = file.Import();
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "client/import/import_scene.h"

namespace penumbra {

struct GltfFile {
  GltfFile();

  // Each returns what it added by its index.
  int AddView(const void* data, size_t size);
  int AddFloats(const std::vector<float>& values, const std::string& type);
  int AddIndices(const std::vector<uint16_t>& values);
  // A mesh of one primitive; without `indices`, not indexed.
  int AddTriangles(const std::vector<Vec3>& positions, const std::vector<uint16_t>& indices);

  // The document with its buffer as a data URI, or as a GLB.
  std::string Text() const;
  std::string Glb() const;
  absl::StatusOr<ImportedScene> Import() const;

  nlohmann::json document;
  std::string bytes;
};

// (0,0,0) (1,0,0) (1,1,0) (0,1,0) and its two triangles, front towards +z.
std::vector<Vec3> UnitSquare();
std::vector<uint16_t> SquareIndices();

}  // namespace penumbra
