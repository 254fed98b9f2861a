// Skinned primitives, bent into the pose that the file's joints are in.
#pragma once

#include <map>
#include <vector>

#include "absl/status/statusor.h"
#include "client/import/gltf/document.h"
#include "client/import/gltf/geometry.h"
#include "render/math/vec.h"

namespace penumbra::gltf {

// world_from_joint · joint_from_mesh for each joint of `skin`, with `world_from_node` by node
// index; joints outside the scene count as at the origin.
//
// Errors  kInvalidArgument: fewer inverse bind matrices than joints
// Source  glTF 2.0, §3.7.3
absl::StatusOr<std::vector<DMat4>> JointMatrices(Document& document, int skin,
                                                 const std::map<int, DMat4>& world_from_node);

// Moves the positions of `geometry` to world space, and drops its normals.
//
// Errors  kInvalidArgument, reason INDEX_RANGE: a joint that the skin does not have
absl::Status Bend(const SkinWeights& weights, const std::vector<DMat4>& joints,
                  const std::string& path, MeshGeometry& geometry);

}  // namespace penumbra::gltf
