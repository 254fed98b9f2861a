// Where a node's mesh lies: once, or as often as EXT_mesh_gpu_instancing says.
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "client/import/gltf/document.h"
#include "client/import/gltf/transforms.h"

namespace penumbra::gltf {

// Errors  kInvalidArgument, reasons LENGTH: attributes of different counts; ROTATION: length 0; and
//         those of ReadFloats
absl::StatusOr<std::vector<Affine>> PlacementsOf(Document& document, const PlacedNode& placed);

}  // namespace penumbra::gltf
