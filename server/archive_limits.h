// What the server bounds of exports and imports of scenes.
#pragma once

#include <chrono>
#include <cstdint>

namespace penumbra {

struct ArchiveLimits {
  // At a time: each reads or writes one scene's files.
  uint32_t max_transfers = 8;
  // Of one of them: the history that it reads is not compacted meanwhile.
  std::chrono::seconds max_time{3'600};
};

}  // namespace penumbra
