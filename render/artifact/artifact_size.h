// What artifacts take in memory.
#pragma once

#include <cstddef>

#include "render/artifact/artifact.h"

namespace penumbra {

// Roughly; what it shares with others counts as well.
size_t BytesOf(const Artifact& artifact);

}  // namespace penumbra
