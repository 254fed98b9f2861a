// Values on whose sides code takes different ways.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "tests/fuzz/kit/draws.h"

namespace penumbra::fuzzing {

// Each is `now` slightly changed, or one of a list of edges.
uint64_t TellingInteger(Draws& draws, uint64_t now);
// Infinities, no numbers, denormal ones and others past what single precision holds included.
double TellingReal(Draws& draws, double now);
float TellingReal(Draws& draws, float now);

// `words` are texts and bytes that mean something elsewhere: ids, hashes.
// UTF-8, as far as `now` and the words are.
std::string TellingText(Draws& draws, const std::string& now, std::span<const std::string> words);
std::string TellingBytes(Draws& draws, const std::string& now, std::span<const std::string> words);

}  // namespace penumbra::fuzzing
