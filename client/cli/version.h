// What this program calls itself.
#pragma once

#include <string>

namespace penumbra {

inline std::string VersionText() { return "penumbra " PENUMBRA_VERSION; }

}  // namespace penumbra
