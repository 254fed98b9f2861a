// What else than the scene decides an artifact's texels, to the last bit: the program, the
// processor's instructions, the device that draws.
#pragma once

#include <string>

#include "penumbra/v1/server_info.pb.h"

namespace penumbra {

// Equal where everything of this is. The program and the libraries that it has loaded are told by
// their build ids, which linkers make of all that is in them; where there are none no two runs are
// equal.
std::string ResultOrigin(const v1::GlInfo& gl);

}  // namespace penumbra
