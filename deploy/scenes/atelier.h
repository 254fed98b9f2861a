// The scene that the project ships: a still life in a studio, made to show soft shadows.
#pragma once

#include <cstdint>
#include <vector>

namespace penumbra::sample {

// As a GLB file; README.md beside this lists the ids.
std::vector<uint8_t> AtelierGlb();

}  // namespace penumbra::sample
