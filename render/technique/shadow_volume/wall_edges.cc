#include "render/technique/shadow_volume/wall_edges.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace penumbra {
namespace {

// What is left of a step without slopes, as a part of it. Where a sample is half the way down,
// either step is a half of both.
constexpr double kLeastStep = 0.35;
// By how much, as a part of them, differences of one slope differ.
constexpr double kSameSlope = 0.25;

// Samples in a row around a gate, which is between the third and the fourth; beyond the map
// infinite.
using Row = std::array<double, 6>;

// Whether there is more at the gate than slopes on both sides would make of it.
bool IsStep(const Row& row) {
  const double step = row[3] - row[2];
  if (!std::isfinite(step)) return true;
  const auto part = [&](int gate) {  // of the step that the difference at another gate is
    const double slope = row[gate + 1] - row[gate];
    return std::isfinite(slope) ? slope / step : 0.0;
  };
  const auto is_same = [&](int gate) { return std::abs(part(gate) - 1) <= kSameSlope; };
  if ((is_same(0) && is_same(1)) || (is_same(3) && is_same(4))) return false;
  const double slopes = std::clamp(part(1), 0.0, 1.0) + std::clamp(part(3), 0.0, 1.0);
  return 1 - 0.5 * slopes >= kLeastStep;
}

Row RowAround(const VolumeGrid& grid, uint32_t x, uint32_t y, bool is_right) {
  Row row;
  for (int k = -2; k <= 3; ++k) {
    const int64_t at_x = int64_t{x} + (is_right ? k : 0), at_y = int64_t{y} + (is_right ? 0 : k);
    const bool is_in = at_x >= 0 && at_y >= 0 && at_x < grid.width() && at_y < grid.height();
    row[k + 2] =
        is_in ? grid.At(static_cast<uint32_t>(at_x), static_cast<uint32_t>(at_y)) : INFINITY;
  }
  return row;
}

}  // namespace

EdgeMap WallEdges(const VolumeGrid& grid, const EdgeMap& edges) {
  EdgeMap kept(grid);
  for (uint32_t y = 0; y < grid.height(); ++y) {
    for (uint32_t x = 0; x < grid.width(); ++x) {
      if (x + 1 < grid.width() && edges.right(x, y) && IsStep(RowAround(grid, x, y, true))) {
        kept.SetRight(x, y);
      }
      if (y + 1 < grid.height() && edges.below(x, y) && IsStep(RowAround(grid, x, y, false))) {
        kept.SetBelow(x, y);
      }
    }
  }
  return kept;
}

}  // namespace penumbra
