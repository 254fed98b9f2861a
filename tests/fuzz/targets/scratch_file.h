// Files of targets whose subjects read files. With TMPDIR=/dev/shm nothing of them reaches a disk.
#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

namespace penumbra::fuzzing {

// Some file systems wait for the disk when a file is written over, but not for a new one.
inline void WriteAnew(const std::filesystem::path& path, std::string_view bytes) {
  std::error_code error;
  std::filesystem::remove(path, error);
  std::ofstream(path, std::ios::binary) << bytes;
}

// Empty where there is none.
inline std::string BytesIn(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace penumbra::fuzzing
