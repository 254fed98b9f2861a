// Damages files the way disks, networks and other programs do; the same seed, the same damage.
#pragma once

#include <cstdint>
#include <string>

namespace penumbra {

// `bytes` with one to four of: a bit flipped, a byte or word set to a telling value, a stretch cut
// out, doubled or moved, a number in the text replaced, the end cut off.
std::string Mutated(const std::string& bytes, uint64_t seed);

}  // namespace penumbra
