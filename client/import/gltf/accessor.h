// Reads accessors: any component type, interleaved or sparse.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/import/gltf/document.h"

namespace penumbra::gltf {

// N elements of `components` numbers each, one after the other.
struct FloatArray {
  int components = 0;
  std::vector<float> values;  // N·components

  size_t size() const { return components == 0 ? 0 : values.size() / components; }
};

// An accessor's numbers; integers that are normalised are mapped to [0, 1] or [−1, 1], others keep
// their value.
//
//   `components`  how many an element may have, one of these
//   `field_path`  what refers to the accessor, for the errors about its type
//
// Errors  kInvalidArgument: SCHEMA, OUT_OF_BOUNDS, INDEX_RANGE (sparse); kResourceExhausted: more
//         elements than a mesh may have; and those of Document::ViewBytes
absl::StatusOr<FloatArray> ReadFloats(Document& document, int accessor,
                                      std::initializer_list<int> components,
                                      const std::string& field_path);

// The same for unsigned integers of one component.
absl::StatusOr<std::vector<uint32_t>> ReadIndices(Document& document, int accessor,
                                                  const std::string& field_path);

}  // namespace penumbra::gltf
