#include "client/import/gltf/draco_mesh.h"

#include <draco/compression/decode.h>

#include <exception>
#include <memory>

#include "absl/strings/str_cat.h"
#include "client/import/source_file.h"
#include "render/scene/field_error.h"

namespace penumbra::gltf {
namespace {

absl::StatusOr<std::unique_ptr<draco::Mesh>> Decode(std::span<const std::byte> packed,
                                                    std::string_view field_path) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(packed.data()), packed.size());
  std::string error = "a damaged mesh";
  try {
    draco::Decoder decoder;
    auto mesh = decoder.DecodeMeshFromBuffer(&buffer);
    if (mesh.ok() && mesh.value() != nullptr) return std::move(mesh).value();
    if (!mesh.ok()) error = mesh.status().error_msg_string();
  } catch (const std::exception& exception) {
    error = exception.what();
  }
  return Malformed("DRACO", field_path,
                   absl::StrCat("found ", Quoted(error), ", need a Draco mesh"));
}

absl::StatusOr<FloatArray> Attribute(const draco::Mesh& mesh, int id, const std::string& path) {
  const draco::PointAttribute* attribute =
      id < 0 ? nullptr : mesh.GetAttributeByUniqueId(static_cast<uint32_t>(id));
  if (attribute == nullptr || attribute->num_components() < 1 || attribute->num_components() > 4) {
    return Malformed("DRACO", path, absl::StrCat("found ", id, ", need the id of an attribute"));
  }
  const int components = attribute->num_components();
  FloatArray out{.components = components,
                 .values = std::vector<float>(size_t(mesh.num_points()) * components)};
  for (uint32_t i = 0; i < mesh.num_points(); ++i) {
    const draco::AttributeValueIndex value = attribute->mapped_index(draco::PointIndex(i));
    if (value.value() >= attribute->size() ||
        !attribute->ConvertValue<float>(value, static_cast<int8_t>(components),
                                        &out.values[size_t(i) * components])) {
      return Malformed("DRACO", path, absl::StrCat("found no value for point ", i, ", need one"));
    }
  }
  return out;
}

}  // namespace

absl::StatusOr<DracoMesh> DecodeDraco(std::span<const std::byte> packed,
                                      const std::map<std::string, int>& attribute_ids,
                                      std::string_view field_path, const SceneLimits& limits) {
  const std::string path(field_path);
  absl::StatusOr<std::unique_ptr<draco::Mesh>> mesh = Decode(packed, path);
  if (!mesh.ok()) return mesh.status();
  if ((*mesh)->num_points() > limits.max_vertices_per_mesh ||
      (*mesh)->num_faces() > limits.max_triangles_per_mesh) {
    return FieldError(
        absl::StatusCode::kResourceExhausted, "TOO_LARGE", path,
        absl::StrCat("found ", (*mesh)->num_points(), " points and ", (*mesh)->num_faces(),
                     " faces, need <= ", limits.max_vertices_per_mesh, " and ",
                     limits.max_triangles_per_mesh));
  }
  DracoMesh out;
  for (const auto& [name, id] : attribute_ids) {
    absl::StatusOr<FloatArray> values =
        Attribute(**mesh, id, absl::StrCat(path, ".attributes.", name));
    if (!values.ok()) return values.status();
    out.attributes.emplace(name, *std::move(values));
  }
  out.indices.reserve(size_t{(*mesh)->num_faces()} * 3);
  for (uint32_t f = 0; f < (*mesh)->num_faces(); ++f) {
    for (const draco::PointIndex& corner : (*mesh)->face(draco::FaceIndex(f))) {
      out.indices.push_back(corner.value());
    }
  }
  return out;
}

}  // namespace penumbra::gltf
