// How a scene is exported or imported.
#pragma once

#include <cstdint>
#include <functional>
#include <stop_token>

namespace penumbra {

struct ArchiveOptions {
  bool with_history = true;  // of an export
  // Bytes so far, and of an import all of them, otherwise 0; on the thread that calls. May be null.
  std::function<void(uint64_t moved_bytes, uint64_t total_bytes)> progress = nullptr;
  std::stop_token stop = {};
};

}  // namespace penumbra
