#include "render/technique/shadow_volume/wall_sides.h"

#include <algorithm>
#include <array>
#include <bit>

namespace penumbra {
namespace {

DVec2 PlaceOf(GridCorner corner) { return DVec2(corner.x, corner.y); }

// Which of a cell's corners no edge parts from corner `at`, as bits.
unsigned TogetherWith(int at, int code) {
  unsigned together = 1u << at;
  for (int k = at; !(code >> k & 1) && (k + 1) % 4 != at; k = (k + 1) % 4) {
    together |= 1u << (k + 1) % 4;
  }
  for (int k = (at + 3) % 4; !(code >> k & 1) && k != at; k = (k + 3) % 4) together |= 1u << k;
  return together;
}

}  // namespace

WallSide WallSides::AtGate(GridCorner from, GridCorner other) const {
  const double here = grid_.At(from.x, from.y), there = grid_.At(other.x, other.y);
  if (here == grid_.nothing()) return {.nearness = here};
  const DVec2 at = PlaceOf(from), on = PlaceOf(other) - at;
  const auto x = static_cast<int>(on.x), y = static_cast<int>(on.y);
  const double ahead = -Step(from, -x, -y).value_or(0.0);  // a sample further towards `other`
  const double tolerance =
      kWallTolerance * (grid_.PixelWidth(grid_.At(from.x, from.y)) + 0.5 * std::abs(ahead));
  if (here > there) {
    const int along_x = std::abs(y), along_y = std::abs(x);
    const DVec2 along(along_x, along_y);
    return {.nearness = here,
            .at = at,
            .slope = ahead * on + SlopeAlong(from, along_x, along_y) * along,
            .tolerance = tolerance,
            .is_near = true};
  }
  return {.nearness = std::min(here + 0.5 * ahead, there),
          .at = at + 0.5 * on,
          .slope = ahead * on,
          .tolerance = tolerance};
}

WallSide WallSides::AtBorder(GridCorner from, GridCorner other) const {
  return {.nearness = grid_.At(from.x, from.y), .at = 0.5 * (PlaceOf(from) + PlaceOf(other))};
}

WallSide WallSides::InCell(GridCorner cell, GridCorner corner) const {
  const auto [x, y] = cell;
  const std::array<GridCorner, 4> corners = {cell, {x + 1, y}, {x + 1, y + 1}, {x, y + 1}};
  size_t at = 0;
  while (corners[at].x != corner.x || corners[at].y != corner.y) ++at;
  const unsigned together = TogetherWith(static_cast<int>(at), edges_.Code(x, y));
  DVec2 place(0.0);
  double sum = 0, lowest = INFINITY;
  bool is_lowest = false;
  for (size_t k = 0; k < 4; ++k) {
    const double here = grid_.At(corners[k].x, corners[k].y);
    const bool is_of_it = together >> k & 1;
    if (here <= lowest) is_lowest = is_of_it || (here == lowest && is_lowest);
    lowest = std::min(lowest, here);
    if (is_of_it) sum += here, place += PlaceOf(corners[k]);
  }
  const int count = std::popcount(together);
  return {.nearness = sum / count,
          .at = is_lowest ? PlaceOf(cell) + 0.5 : place / static_cast<double>(count),
          .is_near = !is_lowest};
}

std::optional<double> WallSides::Step(GridCorner from, int x, int y) const {
  const GridCorner to{from.x + static_cast<uint32_t>(x), from.y + static_cast<uint32_t>(y)};
  if (to.x >= grid_.width() || to.y >= grid_.height()) return std::nullopt;  // far above: below 0
  const GridCorner first{std::min(from.x, to.x), std::min(from.y, to.y)};
  const bool is_edge = y == 0 ? edges_.right(first.x, first.y) : edges_.below(first.x, first.y);
  const double here = grid_.At(from.x, from.y), there = grid_.At(to.x, to.y);
  if (is_edge || here == grid_.nothing() || there == grid_.nothing()) return std::nullopt;
  return there - here;
}

double WallSides::SlopeAlong(GridCorner at, int x, int y) const {
  const auto on = Step(at, x, y), back = Step(at, -x, -y);
  if (on && back) return 0.5 * (*on - *back);
  return on ? *on : -back.value_or(0.0);
}

}  // namespace penumbra
