#include "render/scene/jittered_grid.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "render/math/random.h"

namespace penumbra {
namespace {

// Where the order's random numbers stand among those of the jitter, which has one for each cell.
constexpr uint64_t kShiftIndex = 1u << 20;

// One of n cells of equal area that tile the unit square.
struct Cell {
  DVec2 corner;
  DVec2 size;
};

// Rows of about √n cells; where n is no rectangle, some rows hold one cell more and are that much
// taller, so that all areas stay 1/n. `aspect` is the light's width over its height: cells come out
// roughly square.
std::vector<Cell> TileUnitSquare(uint32_t n, double aspect) {
  const double ideal_rows = std::sqrt(n / std::clamp(aspect, 1.0 / n, 1.0 * n));
  const auto rows = std::clamp<uint32_t>(static_cast<uint32_t>(std::lround(ideal_rows)), 1, n);
  std::vector<Cell> cells;
  cells.reserve(n);
  double bottom = 0;
  for (uint32_t row = 0; row < rows; ++row) {
    const uint32_t first = static_cast<uint32_t>(uint64_t{n} * row / rows);
    const uint32_t columns = static_cast<uint32_t>(uint64_t{n} * (row + 1) / rows) - first;
    const DVec2 size(1.0 / columns, static_cast<double>(columns) / n);
    for (uint32_t column = 0; column < columns; ++column) {
      cells.push_back({{column * size.x, bottom}, size});
    }
    bottom += size.y;
  }
  return cells;
}

// Point `index` of the two-dimensional Sobol' sequence, its digits in base 2 shifted by `shift`. Of
// the first 2^m points one lies in each box 2^-a × 2^-b with a + b = m.
DVec2 SobolPoint(uint32_t index, uint32_t shift_x, uint32_t shift_y) {
  uint32_t x = shift_x, y = shift_y;
  uint32_t direction_x = 1u << 31, direction_y = 1u << 31;
  for (uint32_t digits = index; digits != 0; digits >>= 1) {
    if (digits & 1) {
      x ^= direction_x;
      y ^= direction_y;
    }
    direction_x >>= 1;
    direction_y ^= direction_y >> 1;
  }
  return {std::ldexp(x, -32), std::ldexp(y, -32)};
}

// The cell that holds `point`; cells are sorted by rows.
uint32_t CellAt(const std::vector<Cell>& cells, DVec2 point) {
  const auto row_above = std::partition_point(
      cells.begin(), cells.end(), [&](const Cell& cell) { return cell.corner.y <= point.y; });
  const double row = std::prev(row_above)->corner.y;
  const auto next = std::partition_point(cells.begin(), row_above, [&](const Cell& cell) {
    return cell.corner.y < row || cell.corner.x <= point.x;
  });
  return static_cast<uint32_t>(std::prev(next) - cells.begin());
}

double Distance2(const Cell& cell, DVec2 point, double aspect) {
  const DVec2 below = cell.corner - point, above = point - cell.corner - cell.size;
  const DVec2 outside = glm::max(glm::max(below, above), DVec2(0.0)) * DVec2(aspect, 1.0);
  return glm::dot(outside, outside);
}

// The order in which the points of a Sobol' sequence visit the cells: each takes its own cell or,
// where that is taken, the nearest that is not.
std::vector<uint32_t> SobolOrder(const std::vector<Cell>& cells, double aspect, uint64_t seed) {
  const auto shift = [&](uint32_t dimension) {
    return static_cast<uint32_t>(std::ldexp(UniformAt(seed, kShiftIndex, dimension), 32));
  };
  const uint32_t shift_x = shift(0), shift_y = shift(1);
  std::vector<bool> is_taken(cells.size(), false);
  std::vector<uint32_t> order;
  order.reserve(cells.size());
  for (uint32_t i = 0; i < cells.size(); ++i) {
    const DVec2 point = SobolPoint(i, shift_x, shift_y);
    uint32_t cell = CellAt(cells, point);
    double least = is_taken[cell] ? std::numeric_limits<double>::infinity() : 0;
    for (uint32_t c = 0; c < cells.size() && least > 0; ++c) {
      const double distance2 = Distance2(cells[c], point, aspect);
      if (is_taken[c] || distance2 >= least) continue;
      least = distance2;
      cell = c;
    }
    is_taken[cell] = true;
    order.push_back(cell);
  }
  return order;
}

}  // namespace

std::vector<DVec2> JitteredGrid(uint32_t n, double aspect, uint64_t seed) {
  const std::vector<Cell> cells = TileUnitSquare(n, aspect);
  std::vector<DVec2> points;
  points.reserve(n);
  for (const uint32_t c : SobolOrder(cells, aspect, seed)) {
    const DVec2 jitter(UniformAt(seed, c, 0), UniformAt(seed, c, 1));
    points.push_back(cells[c].corner + jitter * cells[c].size);
  }
  return points;
}

}  // namespace penumbra
