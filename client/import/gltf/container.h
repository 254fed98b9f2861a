// The GLB container: a header and chunks, of which JSON and BIN are known.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

#include "absl/status/statusor.h"

namespace penumbra::gltf {

struct Container {
  std::string_view json;                          // both views are into the bytes given
  std::optional<std::span<const std::byte>> bin;  // absent: no BIN chunk
};

bool IsGlb(std::span<const std::byte> bytes);

// Splits a GLB of version 2; any other bytes are taken as JSON text, with or without a UTF-8 mark.
//
// Errors  kInvalidArgument, reason GLB: "glb.length: …", "glb.chunks[1].length: …"
// Source  glTF 2.0, §4.4
absl::StatusOr<Container> SplitContainer(std::span<const std::byte> bytes);

}  // namespace penumbra::gltf
