// Exact distances in a strip of rows, compiled for several instruction sets and chosen when first
// called.
//
// First a strip is summed up: how far from its ends each column's lit texels are. Carried from one
// strip to the next that tells what lies beyond them, and each can be worked on alone.
#pragma once

#include <cstdint>
#include <span>

namespace penumbra {

// Distance along a column that has no lit texel. Its square exceeds any squared distance in a mask,
// and the sum of two such squares fits 32 bits.
inline constexpr int16_t kNoneLit = 32767;

// Rows that follow each other in a mask: H·W bytes.
struct MaskStrip {
  const uint8_t* blocked;
  uint32_t width;
  uint32_t rows;
};

// Texels from the strip's first row to a column's first lit texel, and from its last row to the
// last one; kNoneLit where a column has none.
//
// Shapes  W columns → W and W
void FindLitEnds(const MaskStrip& strip, std::span<int16_t> first, std::span<int16_t> last);

// What lies beyond a strip for the next one: the lesser of the strip's own ends and of what lay
// beyond it, `rows` further away.
//
// Shapes  W and W → W
void CarryEnds(std::span<const int16_t> ends, std::span<const int16_t> beyond, uint32_t rows,
               std::span<int16_t> next);

// Distance from each texel of the strip to the nearest lit texel of the mask, in texels.
//
// `above`, `below`  for each column the distance from the row before the strip, and from the row
//                   after it, to the nearest lit texel on that side, which may be that row's own
// Shapes   H·W and W and W → H·W
// Precond  some texel of the mask is lit
void MeasureStrip(const MaskStrip& strip, std::span<const int16_t> above,
                  std::span<const int16_t> below, float* distances);

}  // namespace penumbra
