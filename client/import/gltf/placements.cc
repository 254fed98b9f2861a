#include "client/import/gltf/placements.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "client/import/gltf/accessor.h"
#include "client/import/source_file.h"

namespace penumbra::gltf {
namespace {

// Each is empty or has an entry an instance.
struct Columns {
  FloatArray translations, rotations, scales;

  size_t count() const { return std::max({translations.size(), rotations.size(), scales.size()}); }
};

absl::StatusOr<Columns> ReadColumns(Document& document, const tinygltf::Value& attributes,
                                    const std::string& path) {
  Columns columns;
  const struct {
    const char* name;
    int components;
    FloatArray& array;
  } sources[] = {{"TRANSLATION", 3, columns.translations},
                 {"ROTATION", 4, columns.rotations},
                 {"SCALE", 3, columns.scales}};
  for (const auto& source : sources) {
    if (!attributes.Has(source.name)) continue;
    auto values = ReadFloats(document, attributes.Get(source.name).GetNumberAsInt(),
                             {source.components}, absl::StrCat(path, ".", source.name));
    if (!values.ok()) return values.status();
    source.array = *std::move(values);
  }
  for (const auto& source : sources) {
    if (source.array.size() != 0 && source.array.size() != columns.count()) {
      return Malformed("LENGTH", absl::StrCat(path, ".", source.name),
                       absl::StrCat("found ", source.array.size(), " elements, need ",
                                    columns.count(), ", as many as the others"));
    }
  }
  return columns;
}

DVec3 ThreeAt(const FloatArray& array, size_t i, DVec3 fallback) {
  if (array.size() == 0) return fallback;
  const float* v = &array.values[3 * i];
  return {v[0], v[1], v[2]};
}

}  // namespace

absl::StatusOr<std::vector<Affine>> PlacementsOf(Document& document, const PlacedNode& placed) {
  const auto* instancing =
      FindExtension(document.model().nodes[placed.node].extensions, "EXT_mesh_gpu_instancing");
  if (instancing == nullptr) return std::vector<Affine>{ToAffine(placed.world_from_node)};
  const std::string path =
      absl::StrCat("nodes[", placed.node, "].extensions.EXT_mesh_gpu_instancing.attributes");
  const absl::StatusOr<Columns> columns =
      ReadColumns(document, instancing->Get("attributes"), path);
  if (!columns.ok()) return columns.status();
  std::vector<Affine> placements;
  for (size_t i = 0; i < columns->count(); ++i) {
    DVec4 rotation(0, 0, 0, 1);
    if (columns->rotations.size() != 0) {
      const float* r = &columns->rotations.values[4 * i];
      rotation = DVec4(r[0], r[1], r[2], r[3]);
    }
    const double length = glm::length(rotation);
    if (!(length > 0.0)) {
      return Malformed("ROTATION", absl::StrCat(path, ".ROTATION[", i, "]"),
                       absl::StrCat("found length ", length, ", need 1"));
    }
    placements.push_back(
        ToAffine(placed.world_from_node * FromTrs(ThreeAt(columns->translations, i, DVec3(0.0)),
                                                  rotation / length,
                                                  ThreeAt(columns->scales, i, DVec3(1.0)))));
  }
  return placements;
}

}  // namespace penumbra::gltf
