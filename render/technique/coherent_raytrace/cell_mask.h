// A set of the cells that a light is divided into.
//
//   CellMask todo = predicted.Boundary() | CellMask::Exterior(side);
//   todo.ForEach([&](uint32_t cell) { … });
#pragma once

#include <array>
#include <bit>
#include <cstdint>

namespace penumbra {

// One bit for each cell of an N×N grid; cell (x, y) is number 32·y + x, whatever N.
class CellMask {
 public:
  static constexpr uint32_t kMaxSide = 32;

  CellMask() = default;
  explicit CellMask(uint32_t side) : side_(side) {}

  [[gnu::always_inline]] static CellMask All(uint32_t side) {
    CellMask all(side);
    for (uint32_t y = 0; y < side; ++y) all.rows_[y] = all.FullRow();
    return all;
  }
  // The cells x0 … x1 − 1 of rows y0 … y1 − 1.
  static CellMask Block(uint32_t side, uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1) {
    CellMask block(side);
    const auto row = static_cast<uint32_t>(((uint64_t{1} << (x1 - x0)) - 1) << x0);
    for (uint32_t y = y0; y < y1; ++y) block.rows_[y] = row;
    return block;
  }
  // The cells at the edges of the light.
  static CellMask Exterior(uint32_t side) {
    CellMask exterior(side);
    for (uint32_t y = 0; y < side; ++y) exterior.rows_[y] = 1u | 1u << (side - 1);
    exterior.rows_[0] = exterior.rows_[side - 1] = exterior.FullRow();
    return exterior;
  }

  uint32_t side() const { return side_; }
  bool Has(uint32_t cell) const { return rows_[cell / kMaxSide] >> cell % kMaxSide & 1; }
  void Add(uint32_t cell) { rows_[cell / kMaxSide] |= 1u << cell % kMaxSide; }
  void AddIf(bool is_in, uint32_t cell) {
    rows_[cell / kMaxSide] |= uint32_t{is_in} << cell % kMaxSide;
  }
  void SetRow(uint32_t y, uint32_t cells) { rows_[y] = cells & FullRow(); }
  uint32_t Count() const {
    uint32_t count = 0;
    for (uint32_t y = 0; y < side_; y += 2) {
      count += std::popcount(uint64_t{rows_[y]} << 32 | rows_[y + 1]);
    }
    return count;
  }
  [[gnu::always_inline]] bool empty() const {
    uint32_t any = 0;
    ForRows([&](uint32_t y) { any |= rows_[y]; });
    return any == 0;
  }

  [[gnu::always_inline]] CellMask& operator|=(const CellMask& other) {
    ForRows([&](uint32_t y) { rows_[y] |= other.rows_[y]; });
    return *this;
  }
  [[gnu::always_inline]] CellMask& operator&=(const CellMask& other) {
    ForRows([&](uint32_t y) { rows_[y] &= other.rows_[y]; });
    return *this;
  }
  // Without those of `other`.
  [[gnu::always_inline]] CellMask& operator-=(const CellMask& other) {
    ForRows([&](uint32_t y) { rows_[y] &= ~other.rows_[y]; });
    return *this;
  }
  [[gnu::always_inline]] friend CellMask operator|(CellMask a, const CellMask& b) { return a |= b; }
  [[gnu::always_inline]] friend CellMask operator&(CellMask a, const CellMask& b) { return a &= b; }
  [[gnu::always_inline]] friend CellMask operator-(CellMask a, const CellMask& b) { return a -= b; }
  friend bool operator==(const CellMask&, const CellMask&) = default;

  // With the four neighbours of each cell.
  [[gnu::always_inline]] CellMask Dilated() const {
    std::array<uint32_t, kMaxSide + 2> above{};  // rows, one further down
    ForRows([&](uint32_t y) { above[y + 1] = rows_[y]; });
    CellMask dilated(side_);
    ForRows([&, full = FullRow()](uint32_t y) {
      const uint32_t row = rows_[y];
      dilated.rows_[y] = (row | row << 1 | row >> 1 | above[y] | above[y + 2]) & full;
    });
    for (uint32_t y = side_; y < kMaxSide; ++y) dilated.rows_[y] = 0;
    return dilated;
  }
  // The cells that have a neighbour, of four, on the other side of the set's edge.
  [[gnu::always_inline]] CellMask Boundary() const {
    return Dilated() & (All(side_) - *this).Dilated();
  }

  // Calls `visit(cell)` block by block of 4×4 cells, so that neighbours come close to each other.
  template <typename Visit>
  [[gnu::always_inline]] void ForEach(Visit visit) const {
    for (uint32_t y = 0; y < side_; y += kBlockSide) {
      for (uint32_t x = 0; x < side_; x += kBlockSide) {
        for (uint32_t block = BlockAt(x, y); block != 0; block &= block - 1) {
          visit(CellInBlock(x, y, std::countr_zero(block)));
        }
      }
    }
  }

 private:
  // Of a block of 4×4 cells, a bit for each: cell (x0 + k % 4, y0 + k / 4) is bit k. x0 and y0 are
  // multiples of 4.
  static constexpr uint32_t kBlockSide = 4;
  uint32_t BlockAt(uint32_t x0, uint32_t y0) const {
    return (rows_[y0] >> x0 & 15) | (rows_[y0 + 1] >> x0 & 15) << 4 |
           (rows_[y0 + 2] >> x0 & 15) << 8 | (rows_[y0 + 3] >> x0 & 15) << 12;
  }
  static uint32_t CellInBlock(uint32_t x0, uint32_t y0, int bit) {
    const auto k = static_cast<uint32_t>(bit);
    return (y0 + k / kBlockSide) * kMaxSide + x0 + k % kBlockSide;
  }

  // All rows that may have cells, so many at once that they are a few vector instructions.
  template <typename Visit>
  [[gnu::always_inline]] void ForRows(Visit visit) const {
    for (uint32_t y = 0; y < kMaxSide / 2; ++y) visit(y);
    if (side_ <= kMaxSide / 2) return;
    for (uint32_t y = kMaxSide / 2; y < kMaxSide; ++y) visit(y);
  }
  uint32_t FullRow() const { return static_cast<uint32_t>((uint64_t{1} << side_) - 1); }

  uint32_t side_ = 0;
  std::array<uint32_t, kMaxSide> rows_{};
};

}  // namespace penumbra
