// Where a depth map goes from one surface to another.
//
//   const EdgeMap edges = FindEdges(grid, {}, ids);
//   edges.ForEachCell([&](uint32_t x, uint32_t y, int code) { … });   // those with an edge
#pragma once

#include <bit>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "render/artifact/volume_grid.h"
#include "render/technique/shadow_volume/edge_thresholds.h"

namespace penumbra {

struct EdgeOptions {
  // None: ChooseThresholds.
  std::optional<EdgeThresholds> thresholds;
  // Edges that end in the open are followed with lowered thresholds.
  bool follows_dangling = true;
};

// A flag between every two neighbours, as bits in words of 64 a row.
//
// A cell's code has a bit for each of its sides: 0 between its corners 0 and 1, 1 between 1 and 2,
// 2 between 2 and 3, 3 between 3 and 0.
class EdgeMap {
 public:
  explicit EdgeMap(const VolumeGrid& grid);

  bool right(uint32_t x, uint32_t y) const { return Bit(right_, x, y); }  // (x, y), (x + 1, y)
  bool below(uint32_t x, uint32_t y) const { return Bit(below_, x, y); }  // (x, y), (x, y + 1)
  void SetRight(uint32_t x, uint32_t y) { Word(right_, x, y) |= uint64_t{1} << (x % 64); }
  void SetBelow(uint32_t x, uint32_t y) { Word(below_, x, y) |= uint64_t{1} << (x % 64); }

  int Code(uint32_t x, uint32_t y) const {
    return right(x, y) | below(x + 1, y) << 1 | right(x, y + 1) << 2 | below(x, y) << 3;
  }
  // Sets side `side` of a cell.
  void SetSide(uint32_t x, uint32_t y, int side);

  // Calls `take(x, y, code)` for each cell with a code that is not 0, row by row.
  template <typename Take>
  void ForEachCell(const Take& take) const {
    for (uint32_t y = first_y_; y < end_y_; ++y) {
      for (uint32_t word = 0; word < words_; ++word) {
        for (uint64_t bits = CellsWithEdges(word, y); bits != 0; bits &= bits - 1) {
          const uint32_t x = 64 * word + static_cast<uint32_t>(std::countr_zero(bits));
          if (const int code = Code(x, y); code != 0) take(x, y, code);
        }
      }
    }
  }

  // Flags that are set, of those between two samples of which one sees something.
  double fraction() const;
  size_t flag_count() const;
  size_t place_count() const { return place_count_; }

  uint32_t words() const { return words_; }
  uint64_t* RightWords(uint32_t y) { return &right_[size_t{y} * words_]; }
  uint64_t* BelowWords(uint32_t y) { return &below_[size_t{y} * words_]; }

 private:
  bool Bit(const std::vector<uint64_t>& bits, uint32_t x, uint32_t y) const {
    return bits[size_t{y} * words_ + x / 64] >> (x % 64) & 1;
  }
  uint64_t& Word(std::vector<uint64_t>& bits, uint32_t x, uint32_t y) {
    return bits[size_t{y} * words_ + x / 64];
  }
  // Bits of a word's cells that are in the surface and may have an edge.
  uint64_t CellsWithEdges(uint32_t word, uint32_t y) const;

  uint32_t width_, height_, words_;
  uint32_t first_x_, first_y_, end_x_, end_y_;  // cells
  std::vector<uint64_t> right_, below_;
  size_t place_count_ = 0;  // between two samples of which one sees something
};

// Flags are set where nearness differs by more than the high threshold, but within three such
// differences in a row, which are a slope; by more than the low one where the difference has its
// own maximum; between samples of which one sees nothing; and between those of different ids. Where
// an edge ends within a cell, the greatest of the cell's other differences that would do with lower
// thresholds is flagged too, and on from there.
//
// ids     one a sample of the map, row by row; empty: not known
// Cost    about 1 ns a sample, and 50 ns a candidate
// Source  McCool 2000, §3; departs: a difference that is the greatest on one side and no less than
//         its neighbour on the other is a maximum, since an edge may take two steps; what is so
//         close to the contact of two surfaces that it has no maximum is left to `high`
EdgeMap FindEdges(const VolumeGrid& grid, const EdgeOptions& options,
                  std::span<const uint32_t> ids = {});

}  // namespace penumbra
