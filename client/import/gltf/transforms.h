// Where the nodes of a scene lie.
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "client/import/warnings.h"
#include "render/math/vec.h"
#include "tiny_gltf.h"

namespace penumbra::gltf {

struct PlacedNode {
  int node = 0;
  DMat4 world_from_node{1.0};
};

// All nodes of the default scene, parents first; of the first scene where none is the default, and
// every root where there is no scene at all. Rotations that are not of length 1 are normalised.
//
// Errors  kInvalidArgument, reasons CYCLE: a node is reached twice; DEPTH; ROTATION: length 0;
//         AFFINE: a matrix's last row is not 0 0 0 1; NON_FINITE
absl::StatusOr<std::vector<PlacedNode>> PlaceNodes(const tinygltf::Model& model,
                                                   Warnings& warnings);

// translation · rotation · scale; `rotation` is x y z w, of length 1.
DMat4 FromTrs(DVec3 translation, DVec4 rotation, DVec3 scale);

// The upper three rows.
Affine ToAffine(const DMat4& matrix);

}  // namespace penumbra::gltf
