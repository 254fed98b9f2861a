// The picture on the sample scene's leaf cards: a frond in green, clear around it.
#pragma once

#include <cstdint>
#include <vector>

namespace penumbra::sample {

// A PNG file of 128×128 texels; the stem stands in the middle and grows from the last row to the
// first.
std::vector<uint8_t> LeafPng();

}  // namespace penumbra::sample
