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

// Which parts and cells have a blocker, of one prediction at a time: for any number of samplers
// that take turns.
class PartTable {
 public:
  explicit PartTable(const CellGrid& grid)
      : marks_of_parts_(grid.off() + 1),
        marks_of_cells_(kNoCell + 1),
        cell_of_part_(grid.off() + 1) {
    for (uint32_t part = 0; part < grid.off(); ++part) {
      const uint32_t x = part % grid.along() / grid.parts, y = part / grid.along() / grid.parts;
      cell_of_part_[part] = CellMask::kMaxSide * y + x;
    }
    cell_of_part_[grid.off()] = kNoCell;
  }

  // Forgets what was kept before. The last blocker of each part goes to the end, in their order.
  // Returns how many these are.
  //
  // part  that each blocker hides (PartsBehind)
  size_t KeepLast(std::span<const uint32_t> part, Vec4* blockers);
  bool HasBlocker(uint32_t part) const { return marks_of_parts_[part] == mark_; }
  // The cells with a blocker in some part.
  CellMask Cells(uint32_t side) const;

 private:
  static constexpr uint32_t kNoCell = CellMask::kMaxSide * CellMask::kMaxSide;

  void NextMark();

  // The mark of the prediction at hand, or one of those before it.
  std::vector<uint32_t> marks_of_parts_, marks_of_cells_;
  uint32_t mark_ = 0;
  std::vector<uint32_t> cell_of_part_;
};

inline void PartTable::NextMark() {
  if (mark_ == std::numeric_limits<uint32_t>::max()) {
    std::ranges::fill(marks_of_parts_, 0u);
    std::ranges::fill(marks_of_cells_, 0u);
    mark_ = 0;
  }
  ++mark_;
}

inline size_t PartTable::KeepLast(std::span<const uint32_t> part, Vec4* blockers) {
  NextMark();
  const uint32_t mark = mark_;
  uint32_t* const of_parts = marks_of_parts_.data();
  uint32_t* const of_cells = marks_of_cells_.data();
  const uint32_t* const cell_of_part = cell_of_part_.data();
  of_parts[marks_of_parts_.size() - 1] = mark;  // what is off the light is not kept
  // From the last one, to the end, without branches: which are kept is as good as random.
  size_t kept = part.size();
  for (size_t i = part.size(); i-- > 0;) {
    const uint32_t p = part[i];
    blockers[kept - 1] = blockers[i];
    kept -= of_parts[p] != mark;
    of_parts[p] = mark;
    of_cells[cell_of_part[p]] = mark;
  }
  return part.size() - kept;
}

inline CellMask PartTable::Cells(uint32_t side) const {
  CellMask cells(side);
  for (uint32_t y = 0; y < side; ++y) {
    const uint32_t* const marks = &marks_of_cells_[CellMask::kMaxSide * y];
    uint32_t row = 0;
    for (uint32_t x = 0; x < CellMask::kMaxSide; ++x) row |= uint32_t{marks[x] == mark_} << x;
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
