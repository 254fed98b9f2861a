// What the server calls itself.
#pragma once

#include <cstdint>

namespace penumbra {

inline constexpr char kServerName[] = "penumbra 0.1.0";
inline constexpr uint32_t kProtocolVersion = 1;

}  // namespace penumbra
