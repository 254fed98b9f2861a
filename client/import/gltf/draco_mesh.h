// Primitives packed by KHR_draco_mesh_compression.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "client/import/gltf/accessor.h"
#include "render/scene/scene_limits.h"

namespace penumbra::gltf {

struct DracoMesh {
  std::map<std::string, FloatArray> attributes;  // by glTF's names
  std::vector<uint32_t> indices;                 // 3 a triangle
};

// Decodes `packed`, of which `attribute_ids` names the attributes wanted.
//
// Errors  kInvalidArgument, reason DRACO; kResourceExhausted: over a mesh's limits
absl::StatusOr<DracoMesh> DecodeDraco(std::span<const std::byte> packed,
                                      const std::map<std::string, int>& attribute_ids,
                                      std::string_view field_path, const SceneLimits& limits);

}  // namespace penumbra::gltf
