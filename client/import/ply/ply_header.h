// What a PLY file says it holds.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace penumbra::ply {

enum class Format { kAscii, kBinaryLittleEndian, kBinaryBigEndian };

enum class Scalar { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

size_t BytesOf(Scalar type);

struct Property {
  std::string name;
  Scalar type = Scalar::kFloat;
  bool is_list = false;
  Scalar count_type = Scalar::kUint8;  // of a list
};

struct Element {
  std::string name;
  uint64_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  Format format = Format::kAscii;
  std::vector<Element> elements;
  size_t bytes = 0;  // up to and with the line end after end_header
};

// Errors  kInvalidArgument, reason PLY: "header line 4: found …"; counts are checked against the
// size
//         of `file`
absl::StatusOr<Header> ParseHeader(std::span<const std::byte> file);

}  // namespace penumbra::ply
