// Where scenes by other authors are.
#pragma once

#include <cstdlib>
#include <filesystem>

namespace penumbra::testing {

// Where PENUMBRA_SCENES says, or else `fallback`.
inline std::filesystem::path ScenesFolder(const std::filesystem::path& fallback) {
  const char* const folder = std::getenv("PENUMBRA_SCENES");
  return folder != nullptr ? std::filesystem::path(folder) : fallback;
}

}  // namespace penumbra::testing
