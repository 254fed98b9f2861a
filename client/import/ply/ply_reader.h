// The numbers of a PLY file, one after the other, whatever their encoding.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

#include "client/import/ply/ply_header.h"

namespace penumbra::ply {

class Reader {
 public:
  Reader(std::span<const std::byte> body, Format format) : rest_(body), format_(format) {}

  // The next number; nullopt at the end of the file, or where ASCII holds none, or one that `type`
  // cannot hold. ASCII "nan" and "inf" are numbers; what becomes of them the mesh decides.
  std::optional<double> Next(Scalar type);

 private:
  std::optional<double> NextAscii(Scalar type);

  std::span<const std::byte> rest_;
  Format format_;
};

}  // namespace penumbra::ply
