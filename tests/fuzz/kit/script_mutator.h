// Changes scripts where they have a structure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "tests/fuzz/kit/script.h"

namespace penumbra::fuzzing {

// Changes bytes of which no more is known: libFuzzer's way, or that of mutation.h.
using ByteMutator = std::function<std::string(std::string bytes, size_t max_bytes)>;

// The script `bytes` with one payload changed as what it is, or with steps added, dropped, doubled
// or moved: at most `max_bytes` long.
std::string MutatedScript(std::span<const StepKind> kinds, std::string_view bytes, size_t max_bytes,
                          uint64_t seed, const ByteMutator& mutate_bytes);

// Steps of the one among those of the other.
std::string CrossedScripts(std::string_view a, std::string_view b, size_t max_bytes, uint64_t seed);

}  // namespace penumbra::fuzzing
