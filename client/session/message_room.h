// How much of a message is left for what it carries.
#pragma once

#include <algorithm>
#include <cstddef>

namespace penumbra {

// Where messages are too small to carry anything there is room all the same: the server refuses
// the first one.
inline size_t RoomInMessage(size_t max_message_bytes) {
  constexpr size_t kOverheadBytes = 1024;
  return std::max(max_message_bytes, 2 * kOverheadBytes) - kOverheadBytes;
}

}  // namespace penumbra
