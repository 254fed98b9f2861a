#include "client/import/gltf/transforms.h"

#include <array>
#include <cmath>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "client/import/source_file.h"

namespace penumbra::gltf {
namespace {

// Deeper than any rig made by hand or by exporters.
constexpr size_t kMaxDepth = 4096;
// What rounding to single precision, or to the 8-bit steps some exporters use, leaves of length 1.
constexpr double kUnitTolerance = 0.01;

absl::StatusOr<DMat4> FromMatrix(const std::vector<double>& m, const std::string& path) {
  DMat4 matrix;
  for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = m[i];
  for (int column = 0; column < 4; ++column) {
    const double expected = column == 3 ? 1.0 : 0.0;
    if (!(std::abs(matrix[column][3] - expected) <= 1e-6)) {
      return Malformed("AFFINE", absl::StrCat(path, ".matrix[", column * 4 + 3, "]"),
                       absl::StrCat("found ", matrix[column][3], ", need ", expected));
    }
    matrix[column][3] = expected;
  }
  return matrix;
}

absl::StatusOr<DMat4> LocalTransform(const tinygltf::Node& node, int index, Warnings& warnings) {
  const std::string path = absl::StrCat("nodes[", index, "]");
  if (node.matrix.size() == 16) return FromMatrix(node.matrix, path);
  DVec3 translation(0.0), scale(1.0);
  DVec4 rotation(0, 0, 0, 1);
  if (node.translation.size() == 3) {
    translation = {node.translation[0], node.translation[1], node.translation[2]};
  }
  if (node.scale.size() == 3) scale = {node.scale[0], node.scale[1], node.scale[2]};
  if (node.rotation.size() == 4) {
    const DVec4 given(node.rotation[0], node.rotation[1], node.rotation[2], node.rotation[3]);
    const double length = glm::length(given);
    if (!(length > 0.0) || !std::isfinite(length)) {
      return Malformed("ROTATION", path + ".rotation",
                       absl::StrCat("found length ", length, ", need a quaternion of length 1"));
    }
    if (std::abs(length - 1.0) > kUnitTolerance) {
      warnings.Add(absl::StrCat(path, ".rotation: length is ", length, ", normalised"));
    }
    rotation = given / length;
  }
  return FromTrs(translation, rotation, scale);
}

// The parent of each node, or −1.
absl::StatusOr<std::vector<int>> Parents(const tinygltf::Model& model) {
  std::vector<int> parents(model.nodes.size(), -1);
  for (size_t i = 0; i < model.nodes.size(); ++i) {
    for (size_t k = 0; k < model.nodes[i].children.size(); ++k) {
      int& parent = parents[model.nodes[i].children[k]];
      if (parent >= 0) {
        return Malformed("CYCLE", absl::StrCat("nodes[", i, "].children[", k, "]"),
                         absl::StrCat("found ", model.nodes[i].children[k], ", a child of nodes[",
                                      parent, "] as well, need one parent"));
      }
      parent = static_cast<int>(i);
    }
  }
  return parents;
}

// With one parent a node, whoever is on a cycle reaches no root.
absl::Status CheckAcyclic(const std::vector<int>& parents) {
  std::vector<char> reaches_root(parents.size(), false);
  for (size_t i = 0; i < parents.size(); ++i) {
    size_t steps = 0;
    int node = static_cast<int>(i);
    while (node >= 0 && !reaches_root[node] && steps <= parents.size()) {
      node = parents[node];
      ++steps;
    }
    if (steps > parents.size()) {
      return Malformed("CYCLE", absl::StrCat("nodes[", i, "].children"),
                       "found a node below itself, need a tree");
    }
    for (node = static_cast<int>(i); node >= 0 && !reaches_root[node]; node = parents[node]) {
      reaches_root[node] = true;
    }
  }
  return absl::OkStatus();
}

struct Pending {
  int node;
  size_t depth;
  DMat4 world_from_parent;
};

std::vector<int> Roots(const tinygltf::Model& model, const std::vector<int>& parents,
                       Warnings& warnings) {
  if (!model.scenes.empty()) {
    const int scene = model.defaultScene >= 0 ? model.defaultScene : 0;
    if (model.scenes.size() > 1) {
      warnings.Add(absl::StrCat("scenes: read scenes[", scene, "] only, of ", model.scenes.size()));
    }
    return model.scenes[scene].nodes;
  }
  if (!model.nodes.empty()) warnings.Add("scenes: none, so all root nodes are read");
  std::vector<int> roots;
  for (size_t i = 0; i < parents.size(); ++i) {
    if (parents[i] < 0) roots.push_back(static_cast<int>(i));
  }
  return roots;
}

}  // namespace

DMat4 FromTrs(DVec3 translation, DVec4 rotation, DVec3 scale) {
  const auto [x, y, z, w] = std::array{rotation.x, rotation.y, rotation.z, rotation.w};
  const DVec3 axis_x(1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w));
  const DVec3 axis_y(2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w));
  const DVec3 axis_z(2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y));
  return DMat4(DVec4(scale.x * axis_x, 0), DVec4(scale.y * axis_y, 0), DVec4(scale.z * axis_z, 0),
               DVec4(translation, 1));
}

Affine ToAffine(const DMat4& m) {
  return Affine(Vec3(DVec3(m[0])), Vec3(DVec3(m[1])), Vec3(DVec3(m[2])), Vec3(DVec3(m[3])));
}

absl::StatusOr<std::vector<PlacedNode>> PlaceNodes(const tinygltf::Model& model,
                                                   Warnings& warnings) {
  std::vector<Pending> pending;
  const absl::StatusOr<std::vector<int>> parents = Parents(model);
  if (!parents.ok()) return parents.status();
  if (absl::Status status = CheckAcyclic(*parents); !status.ok()) return status;
  const std::vector<int> roots = Roots(model, *parents, warnings);
  for (auto root = roots.rbegin(); root != roots.rend(); ++root) {
    pending.push_back({*root, 1, DMat4(1.0)});
  }
  std::vector<bool> reached(model.nodes.size(), false);
  std::vector<PlacedNode> placed;
  while (!pending.empty()) {
    const Pending next = pending.back();
    pending.pop_back();
    const std::string path = absl::StrCat("nodes[", next.node, "]");
    // A scene may list a node twice, or below another root.
    if (reached[next.node]) {
      return Malformed("CYCLE", path, "found a node reached twice, need a tree of nodes");
    }
    if (next.depth > kMaxDepth) {
      return Malformed("DEPTH", path,
                       absl::StrCat("found depth ", next.depth, ", need <= ", kMaxDepth));
    }
    reached[next.node] = true;
    absl::StatusOr<DMat4> local = LocalTransform(model.nodes[next.node], next.node, warnings);
    if (!local.ok()) return local.status();
    const DMat4 world = next.world_from_parent * *local;
    if (!IsFinite(ToAffine(world))) {
      return Malformed("NON_FINITE", path, "found a transform that overflows, need finite numbers");
    }
    placed.push_back({next.node, world});
    const std::vector<int>& children = model.nodes[next.node].children;
    for (auto child = children.rbegin(); child != children.rend(); ++child) {
      pending.push_back({*child, next.depth + 1, world});
    }
  }
  return placed;
}

}  // namespace penumbra::gltf
