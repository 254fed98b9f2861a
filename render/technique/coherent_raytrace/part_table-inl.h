// Which parts of a light's cells blockers hide; compiled once for each instruction set.

#if defined(PENUMBRA_PART_TABLE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef PENUMBRA_PART_TABLE_INL_H_
#undef PENUMBRA_PART_TABLE_INL_H_
#else
#define PENUMBRA_PART_TABLE_INL_H_
#endif

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "hwy/highway.h"
#include "render/technique/coherent_raytrace/cell_mask.h"
#include "render/technique/coherent_raytrace/sampler_kernel.h"
#include "render/technique/coherent_raytrace/sampling_settings.h"

HWY_BEFORE_NAMESPACE();
namespace penumbra {
namespace HWY_NAMESPACE {

// The newest blocker of each part and of each cell, of one prediction at a time: for any number of
// samplers that take turns. Blockers are known by their numbers among those given to Keep.
class PartTable {
 public:
  explicit PartTable(const CellGrid& grid)
      : newest_of_part_(grid.off() + 1),
        newest_of_cell_(kNoCell + 1),
        cell_of_part_(grid.off() + 1) {
    for (uint32_t part = 0; part < grid.off(); ++part) {
      const uint32_t x = part % grid.along() / grid.parts, y = part / grid.along() / grid.parts;
      cell_of_part_[part] = CellMask::kMaxSide * y + x;
    }
    cell_of_part_[grid.off()] = kNoCell;
  }

  // Forgets what was kept before.
  //
  // part  that each blocker hides (PartsBehind)
  void Keep(std::span<const uint32_t> part);
  bool IsNewest(uint32_t part, uint32_t number) const {
    return newest_of_part_[part] == first_ + number;
  }
  bool HasBlocker(uint32_t part) const { return newest_of_part_[part] >= first_; }
  // The cells with a blocker in some part.
  CellMask Cells(uint32_t side) const;

 private:
  static constexpr uint32_t kNoCell = CellMask::kMaxSide * CellMask::kMaxSide;

  // Blockers numbered from 1, and again when numbers run out; less than first_ are those of
  // predictions before.
  std::vector<uint32_t> newest_of_part_, newest_of_cell_;
  uint32_t first_ = 1, next_ = 1;
  std::vector<uint32_t> cell_of_part_;
};

inline void PartTable::Keep(std::span<const uint32_t> part) {
  if (next_ > std::numeric_limits<uint32_t>::max() - part.size()) {
    std::ranges::fill(newest_of_part_, 0u);
    std::ranges::fill(newest_of_cell_, 0u);
    next_ = 1;
  }
  first_ = next_;
  uint32_t* const of_part = newest_of_part_.data();
  uint32_t* const of_cell = newest_of_cell_.data();
  const uint32_t* const cell_of_part = cell_of_part_.data();
  uint32_t number = first_;
  for (const uint32_t p : part) {
    of_part[p] = number;
    of_cell[cell_of_part[p]] = number;
    ++number;
  }
  next_ = number;
  newest_of_part_.back() = 0;  // of what is off the light
}

inline CellMask PartTable::Cells(uint32_t side) const {
  CellMask cells(side);
  for (uint32_t y = 0; y < side; ++y) {
    const uint32_t* const newest = &newest_of_cell_[CellMask::kMaxSide * y];
    uint32_t row = 0;
    for (uint32_t x = 0; x < CellMask::kMaxSide; ++x) row |= uint32_t{newest[x] >= first_} << x;
    cells.SetRow(y, row);
  }
  return cells;
}

// What samplers that take turns have in common.
struct SamplerTables {
  explicit SamplerTables(const SamplingSettings& settings)
      : parts({settings.side, settings.parts}) {
    for (uint32_t turn = 0; turn < settings.exterior_turns; ++turn) {
      exterior.push_back(CellMask(settings.side));
    }
    CellMask::Exterior(settings.side).ForEach([&](uint32_t cell) {
      const uint32_t diagonal = cell % CellMask::kMaxSide + cell / CellMask::kMaxSide;
      exterior[diagonal % settings.exterior_turns].Add(cell);
    });
  }

  PartTable parts;
  std::vector<CellMask> exterior;  // the cells at the light's edge, those of each turn
};

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
