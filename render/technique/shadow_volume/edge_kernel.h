// Where neighbours in two rows of a depth map differ, compiled for several instruction sets and
// chosen when first called.
#pragma once

#include <cstdint>

namespace penumbra {

// Differences of more than `low` and `high` times what a pixel is wide there are marked: the
// product of `pixel` and the greater nearness, from infinitely far `pixel`.
struct EdgeLimits {
  float low, high;
  bool from_infinity;
};

// Bit x of each: whether sample x and its right neighbour, or its neighbour in the next row, differ
// by more than the low limit, and by more than the high one. Words of 64, `words` of them.
struct EdgeWords {
  uint64_t *right_low, *right_high;
  uint64_t *next_low, *next_high;
};

// kReadPast floats past both rows are read, and 64 · words are marked, of which the caller clears
// those that are beyond the row.
void MarkDifferences(const float* row, const float* next_row, uint32_t words,
                     const EdgeLimits& limits, const EdgeWords& marks);

}  // namespace penumbra
