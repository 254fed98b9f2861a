// Buffer views packed by EXT_meshopt_compression and KHR_meshopt_compression.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace penumbra::gltf {

struct MeshoptView {
  uint64_t count = 0;   // elements
  uint64_t stride = 0;  // bytes each
  std::string mode;     // ATTRIBUTES, TRIANGLES, INDICES
  std::string filter;   // NONE, OCTAHEDRAL, QUATERNION, EXPONENTIAL
};

// The count·stride bytes that `packed` stands for.
//
// Errors  kInvalidArgument, reason MESHOPT: a stride or count that the mode does not allow, or
// bytes
//         that do not decode; kUnimplemented: a filter of later versions; kResourceExhausted,
//         reason EXPANSION: more output than so few bytes can mean, found before anything is
//         allocated
absl::StatusOr<std::vector<std::byte>> DecodeMeshoptView(const MeshoptView& view,
                                                         std::span<const std::byte> packed,
                                                         std::string_view field_path);

}  // namespace penumbra::gltf
