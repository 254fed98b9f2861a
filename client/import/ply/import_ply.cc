#include "client/import/ply/import_ply.h"

#include <array>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/import/id_table.h"
#include "client/import/ply/ply_header.h"
#include "client/import/ply/ply_reader.h"
#include "client/import/source_file.h"
#include "client/import/warnings.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace ply {
namespace {

constexpr std::array<std::string_view, 6> kVertexNames = {"x", "y", "z", "nx", "ny", "nz"};

absl::Status EndOfData(const Element& element, uint64_t index, const Property& property) {
  return Malformed("PLY", absl::StrCat(Quoted(element.name), "[", index, "].", property.name),
                   "found the end of the file or no number, need a number");
}

class MeshReader {
 public:
  MeshReader(const Header& header, std::span<const std::byte> body, const SceneLimits& limits)
      : header_(header), reader_(body, header.format), limits_(limits) {}

  absl::StatusOr<MeshGeometry> Read(Warnings& warnings);

 private:
  absl::Status CheckCounts() const;
  absl::Status ReadVertices(const Element& element);
  absl::Status ReadFaces(const Element& element);
  absl::Status Skip(const Element& element);
  // The list's items, in `items_`, or a scalar as a list of one.
  absl::Status ReadProperty(const Element& element, uint64_t index, const Property& property);
  absl::Status AddPolygon(uint64_t face);

  const Header& header_;
  Reader reader_;
  const SceneLimits& limits_;
  std::vector<double> items_;
  MeshGeometry geometry_;
};

absl::Status MeshReader::ReadProperty(const Element& element, uint64_t index,
                                      const Property& property) {
  items_.clear();
  double count = 1;
  if (property.is_list) {
    const std::optional<double> length = reader_.Next(property.count_type);
    if (!length || *length < 0) return EndOfData(element, index, property);
    count = *length;
  }
  for (double i = 0; i < count; ++i) {
    const std::optional<double> item = reader_.Next(property.type);
    if (!item) return EndOfData(element, index, property);
    items_.push_back(*item);
  }
  return absl::OkStatus();
}

absl::Status MeshReader::CheckCounts() const {
  for (const Element& element : header_.elements) {
    const uint64_t most = element.name == "vertex" ? limits_.max_vertices_per_mesh
                          : element.name == "face" ? limits_.max_triangles_per_mesh
                                                   : element.count;
    if (element.count > most) {
      return FieldError(absl::StatusCode::kResourceExhausted, "TOO_LARGE",
                        absl::StrCat("element ", element.name),
                        absl::StrCat("found ", element.count, ", need <= ", most));
    }
  }
  return absl::OkStatus();
}

absl::Status MeshReader::ReadVertices(const Element& element) {
  std::array<bool, 6> present{};
  for (const Property& property : element.properties) {
    for (size_t k = 0; k < kVertexNames.size(); ++k) {
      if (property.name == kVertexNames[k] && !property.is_list) present[k] = true;
    }
  }
  if (!present[0] || !present[1] || !present[2]) {
    return Malformed("PLY", "element vertex", "found no x, y and z, need all three");
  }
  const bool has_normals = present[3] && present[4] && present[5];
  for (uint64_t i = 0; i < element.count; ++i) {
    std::array<float, 6> values{};
    for (const Property& property : element.properties) {
      absl::Status status = ReadProperty(element, i, property);
      if (!status.ok()) return status;
      for (size_t k = 0; k < kVertexNames.size(); ++k) {
        if (property.name == kVertexNames[k] && !property.is_list) {
          values[k] = static_cast<float>(items_[0]);
        }
      }
    }
    geometry_.positions.push_back({values[0], values[1], values[2]});
    if (has_normals) geometry_.normals.push_back({values[3], values[4], values[5]});
  }
  return absl::OkStatus();
}

absl::Status MeshReader::AddPolygon(uint64_t face) {
  for (size_t k = 0; k < items_.size(); ++k) {
    if (!(items_[k] >= 0 && items_[k] <= 4294967295.0)) {
      return Malformed("INDEX_RANGE", absl::StrCat("face[", face, "].vertex_indices[", k, "]"),
                       absl::StrCat("found ", items_[k], ", need an index of a vertex"));
    }
  }
  for (size_t k = 2; k < items_.size(); ++k) {
    for (const size_t corner : {size_t{0}, k - 1, k}) {
      geometry_.indices.push_back(static_cast<uint32_t>(items_[corner]));
    }
  }
  if (geometry_.indices.size() / 3 > limits_.max_triangles_per_mesh) {
    return FieldError(
        absl::StatusCode::kResourceExhausted, "TOO_LARGE", "element face",
        absl::StrCat("found more triangles, need <= ", limits_.max_triangles_per_mesh));
  }
  return absl::OkStatus();
}

absl::Status MeshReader::ReadFaces(const Element& element) {
  for (uint64_t i = 0; i < element.count; ++i) {
    for (const Property& property : element.properties) {
      absl::Status status = ReadProperty(element, i, property);
      if (!status.ok()) return status;
      const bool corners = property.name == "vertex_indices" || property.name == "vertex_index";
      if (!corners || !property.is_list) continue;
      status = AddPolygon(i);
      if (!status.ok()) return status;
    }
  }
  return absl::OkStatus();
}

absl::Status MeshReader::Skip(const Element& element) {
  for (uint64_t i = 0; i < element.count; ++i) {
    for (const Property& property : element.properties) {
      absl::Status status = ReadProperty(element, i, property);
      if (!status.ok()) return status;
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<MeshGeometry> MeshReader::Read(Warnings& warnings) {
  absl::Status status = CheckCounts();
  if (!status.ok()) return status;
  for (const Element& element : header_.elements) {
    if (element.name == "vertex" && geometry_.positions.empty()) {
      status = ReadVertices(element);
    } else if (element.name == "face" && geometry_.indices.empty()) {
      status = ReadFaces(element);
    } else {
      warnings.Add(absl::StrCat("element ", Quoted(element.name), ": left out"));
      status = Skip(element);
    }
    if (!status.ok()) return status;
  }
  if (geometry_.indices.empty()) warnings.Add("element face: no triangles, nothing casts a shadow");
  return std::move(geometry_);
}

}  // namespace
}  // namespace ply

absl::StatusOr<ImportedScene> ImportPly(const std::filesystem::path& path,
                                        const SceneLimits& limits) {
  absl::StatusOr<std::vector<std::byte>> file = ReadFile(path);
  if (!file.ok()) return file.status();
  const absl::StatusOr<ply::Header> header = ply::ParseHeader(*file);
  if (!header.ok()) return header.status();
  Warnings warnings;
  ply::MeshReader reader(*header, std::span(*file).subspan(header->bytes), limits);
  absl::StatusOr<MeshGeometry> geometry = reader.Read(warnings);
  if (!geometry.ok()) return geometry.status();
  absl::StatusOr<std::shared_ptr<const Mesh>> mesh = Mesh::Create(*std::move(geometry), limits);
  if (!mesh.ok()) return mesh.status();
  ImportedScene scene;
  scene.instances.push_back(
      {.id = IdTable().Add(path.stem().string(), "mesh"), .mesh = *std::move(mesh)});
  scene.warnings = warnings.lines();
  return scene;
}

}  // namespace penumbra
