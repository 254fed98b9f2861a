// Counting how many bitmaps have each bit set, 512 texels at a time.
//
//   for each sample: Draw(bitmap); AddAndClear(bitmap, planes);
//   for each row:    AddRowCounts(planes, bitmap.stride, row, width, counts + row * width);
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/technique/soft_texture/shadow_bitmap.h"

namespace penumbra {

// Adds `bitmap` to the bit-sliced counters `planes` (plane p holds bit p of each texel's count, in
// the bitmap's layout) and clears it.
void AddAndClear(ShadowBitmap& bitmap, std::span<std::vector<uint32_t>> planes);

// Adds the counters of one row to `counts`, one number a texel.
//
// Shapes  planes of the bitmap's layout → `width` counts
void AddRowCounts(std::span<const std::vector<uint32_t>> planes, uint32_t stride, uint32_t row,
                  uint32_t width, uint16_t* counts);

}  // namespace penumbra
