// Words of files, as they lie in memory here.
#pragma once

#include <bit>
#include <cstdint>
#include <string>

namespace penumbra::fuzzing {

static_assert(std::endian::native == std::endian::little, "files have the least byte first");

inline void PutWord(uint32_t word, std::string& out) {
  out.append(reinterpret_cast<const char*>(&word), sizeof(word));
}

}  // namespace penumbra::fuzzing
