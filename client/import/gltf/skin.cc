#include "client/import/gltf/skin.h"

#include "absl/strings/str_cat.h"
#include "client/import/gltf/accessor.h"
#include "client/import/source_file.h"

namespace penumbra::gltf {

absl::StatusOr<std::vector<DMat4>> JointMatrices(Document& document, int skin,
                                                 const std::map<int, DMat4>& world_from_node) {
  const Skin& source = document.skins()[skin];
  FloatArray inverse_bind;
  if (source.inverse_bind_matrices >= 0) {
    const std::string path = absl::StrCat("skins[", skin, "].inverseBindMatrices");
    auto matrices = ReadFloats(document, source.inverse_bind_matrices, {16}, path);
    if (!matrices.ok()) return matrices.status();
    inverse_bind = *std::move(matrices);
    if (inverse_bind.size() < source.joints.size()) {
      return Malformed("LENGTH", path,
                       absl::StrCat("found ", inverse_bind.size(), " matrices, need ",
                                    source.joints.size(), ", one a joint"));
    }
  }
  std::vector<DMat4> joints;
  for (size_t j = 0; j < source.joints.size(); ++j) {
    const auto placed = world_from_node.find(source.joints[j]);
    DMat4 matrix = placed == world_from_node.end() ? DMat4(1.0) : placed->second;
    if (inverse_bind.size() > 0) {
      DMat4 joint_from_mesh;
      for (int i = 0; i < 16; ++i) joint_from_mesh[i / 4][i % 4] = inverse_bind.values[16 * j + i];
      matrix = matrix * joint_from_mesh;
    }
    joints.push_back(matrix);
  }
  return joints;
}

absl::Status Bend(const SkinWeights& weights, const std::vector<DMat4>& joints,
                  const std::string& path, MeshGeometry& geometry) {
  const size_t pairs = static_cast<size_t>(weights.pairs);
  if (weights.joints.size() != geometry.positions.size() * pairs ||
      weights.weights.size() != weights.joints.size()) {
    return Malformed("LENGTH", path + ".attributes.JOINTS_0",
                     "found another number of joints or weights than of positions, need as many");
  }
  for (size_t v = 0; v < geometry.positions.size(); ++v) {
    const DVec4 bound(DVec3(geometry.positions[v]), 1.0);
    DVec3 moved(0.0);
    double total = 0.0;
    for (size_t k = v * pairs; k < (v + 1) * pairs; ++k) {
      const double weight = weights.weights[k];
      if (!(weight > 0.0)) continue;
      if (!(weights.joints[k] < static_cast<float>(joints.size()))) {
        return Malformed("INDEX_RANGE", absl::StrCat(path, ".attributes.JOINTS_0[", v, "]"),
                         absl::StrCat("found ", weights.joints[k], ", need < ", joints.size(),
                                      ", the number of joints"));
      }
      moved += weight * DVec3(joints[static_cast<size_t>(weights.joints[k])] * bound);
      total += weight;
    }
    // Quantised weights seldom sum to 1 exactly.
    if (total > 0.0) geometry.positions[v] = Vec3(moved / total);
  }
  geometry.normals.clear();
  return absl::OkStatus();
}

}  // namespace penumbra::gltf
