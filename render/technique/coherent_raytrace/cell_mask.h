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

  static CellMask All(uint32_t side) {
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

  // The cells (x, y) with x + y even, or, shifted by 1, odd.
  static CellMask Checkered(uint32_t side, uint32_t shift) {
    CellMask checkered(side);
    for (uint32_t y = 0; y < side; ++y) {
      checkered.rows_[y] = 0x55555555u << (y + shift) % 2 & checkered.FullRow();
    }
    return checkered;
  }

  uint32_t side() const { return side_; }
  bool Has(uint32_t cell) const { return rows_[cell / kMaxSide] >> cell % kMaxSide & 1; }
  void Add(uint32_t cell) { rows_[cell / kMaxSide] |= 1u << cell % kMaxSide; }
  void AddIf(bool is_in, uint32_t cell) {
    rows_[cell / kMaxSide] |= uint32_t{is_in} << cell % kMaxSide;
  }
  uint32_t Count() const {
    uint32_t count = 0;
    for (uint32_t y = 0; y < side_; y += 2) {
      count += std::popcount(uint64_t{rows_[y]} << 32 | rows_[y + 1]);
    }
    return count;
  }
  bool empty() const {
    uint32_t any = 0;
    for (const uint32_t row : rows_) any |= row;
    return any == 0;
  }

  // All rows, so that these are a few vector instructions.
  CellMask& operator|=(const CellMask& other) {
    for (uint32_t y = 0; y < kMaxSide; ++y) rows_[y] |= other.rows_[y];
    return *this;
  }
  CellMask& operator&=(const CellMask& other) {
    for (uint32_t y = 0; y < kMaxSide; ++y) rows_[y] &= other.rows_[y];
    return *this;
  }
  // Without those of `other`.
  CellMask& operator-=(const CellMask& other) {
    for (uint32_t y = 0; y < kMaxSide; ++y) rows_[y] &= ~other.rows_[y];
    return *this;
  }
  friend CellMask operator|(CellMask a, const CellMask& b) { return a |= b; }
  friend CellMask operator&(CellMask a, const CellMask& b) { return a &= b; }
  friend CellMask operator-(CellMask a, const CellMask& b) { return a -= b; }
  friend bool operator==(const CellMask&, const CellMask&) = default;

  // With the eight neighbours of each cell.
  CellMask Dilated() const {
    std::array<uint32_t, kMaxSide + 2> wide{};
    for (uint32_t y = 0; y < kMaxSide; ++y) {
      wide[y + 1] = rows_[y] | rows_[y] << 1 | rows_[y] >> 1;
    }
    CellMask dilated(side_);
    const uint32_t full = FullRow();
    for (uint32_t y = 0; y < kMaxSide; ++y) {
      dilated.rows_[y] = (wide[y] | wide[y + 1] | wide[y + 2]) & full;
    }
    for (uint32_t y = side_; y < kMaxSide; ++y) dilated.rows_[y] = 0;
    return dilated;
  }
  // The cells that have a neighbour, of eight, on the other side of the set's edge.
  CellMask Boundary() const { return Dilated() & (All(side_) - *this).Dilated(); }

  // Calls `visit(cell)` block by block of 4×4 cells, so that neighbours come close to each other.
  template <typename Visit>
  void ForEach(Visit visit) const {
    for (uint32_t y = 0; y < side_; y += 4) {
      const std::array<uint32_t, 4> band{rows_[y], rows_[y + 1], rows_[y + 2], rows_[y + 3]};
      for (uint32_t x = 0; x < side_; x += 4) {
        uint32_t block = (band[0] >> x & 15) | (band[1] >> x & 15) << 4 | (band[2] >> x & 15) << 8 |
                         (band[3] >> x & 15) << 12;
        for (; block != 0; block &= block - 1) {
          const auto k = static_cast<uint32_t>(std::countr_zero(block));
          visit((y + k / 4) * kMaxSide + x + k % 4);
        }
      }
    }
  }

 private:
  uint32_t FullRow() const { return static_cast<uint32_t>((uint64_t{1} << side_) - 1); }

  uint32_t side_ = 0;
  std::array<uint32_t, kMaxSide> rows_{};
};

}  // namespace penumbra
