// Where in render targets of bounded size receivers are drawn: many small ones side by side, large
// ones in bands of rows.
//
//   for (const Page& page : LayOutPages(sizes)) …  // one target each
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace penumbra::texture_gl {

// The most texels that a target has, unless a single row has more: with it a pass takes 8 MB of
// shadows and 4 or 16 MB of sums.
inline constexpr uint32_t kPageTexels = 1u << 20;

struct TexelSize {
  uint32_t width = 0, height = 0;
};

// Rows [first_row, first_row + rows) of receiver `receiver`, its row `first_row` at the bottom.
struct Tile {
  size_t receiver = 0;
  uint32_t first_row = 0, rows = 0;
  uint32_t x = 0, y = 0;
};

struct Page {
  uint32_t width = 0, height = 0;
  std::vector<Tile> tiles;  // overlap nowhere
};

// Shapes  sizes of N receivers, none empty → every row of each in one tile
std::vector<Page> LayOutPages(std::span<const TexelSize> sizes);

}  // namespace penumbra::texture_gl
