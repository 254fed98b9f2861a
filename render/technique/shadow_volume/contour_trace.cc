#include "render/technique/shadow_volume/contour_trace.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>

namespace penumbra {
namespace {

// Where a way leaves a cell: side 0 is to y − 1, side 1 to x + 1, side 2 to y + 1, side 3 to x − 1.
struct Exit {
  GridCorner cell;
  int side;
};

// By how much, as a part of the least step beside them, samples of one surface differ at most. With
// a half of it as many pixels are wrong; without any that hang together a fortieth more, and walls
// are a thirtieth more.
constexpr float kMostOfStep = 0.5f;

int Opposite(int side) { return side ^ 2; }

ContourGate GateAt(const Exit& exit) {
  const auto [x, y] = exit.cell;
  switch (exit.side) {
    case 0:
      return {.left = {x + 1, y}, .right = {x, y}};
    case 1:
      return {.left = {x + 1, y + 1}, .right = {x + 1, y}};
    case 2:
      return {.left = {x, y + 1}, .right = {x + 1, y + 1}};
    default:
      return {.left = {x, y}, .right = {x, y + 1}};
  }
}

class Tracer {
 public:
  Tracer(const VolumeGrid& grid, const EdgeMap& edges)
      : grid_(grid), edges_(edges), taken_(size_t{grid.width()} * grid.height()) {}

  std::vector<Contour> Trace() {
    edges_.ForEachCell([&](uint32_t x, uint32_t y, int code) {
      for (int side = 0; side < 4; ++side) {
        if ((code >> side & 1) && !Next({x, y}, side)) Follow({{x, y}, side}, GridCorner{x, y});
      }
    });
    edges_.ForEachCell([&](uint32_t x, uint32_t y, int code) {
      for (int side = 0; side < 4; ++side) {
        if ((code >> side & 1) && !HasCell(Beyond({{x, y}, side}))) FollowFromBorder({x, y}, side);
      }
    });
    edges_.ForEachCell([&](uint32_t x, uint32_t y, int code) {
      for (int side = 0; side < 4; ++side) {
        if (code >> side & 1) Follow({{x, y}, side}, std::nullopt);
      }
    });
    return std::move(contours_);
  }

 private:
  static GridCorner Beyond(const Exit& exit) {
    const auto [x, y] = exit.cell;
    return {x + (exit.side == 1) - (exit.side == 3), y + (exit.side == 2) - (exit.side == 0)};
  }
  bool HasCell(GridCorner cell) const {  // below 0 it is far above
    return cell.x >= grid_.first_cell() && cell.y >= grid_.first_cell() &&
           cell.x < grid_.end_cell_x() && cell.y < grid_.end_cell_y();
  }

  // Of four samples with edges between all neighbours, the first of those two that are of one
  // surface, which passes between the others; none: no two are. Of what is not there nobody knows
  // whether it hangs together, and where there are two surfaces it is the nearer that does.
  std::optional<int> FirstJoined(GridCorner cell) const {
    const auto [x, y] = cell;
    const std::array<float, 4> r = {grid_.At(x, y), grid_.At(x + 1, y), grid_.At(x + 1, y + 1),
                                    grid_.At(x, y + 1)};
    float least = INFINITY;
    for (size_t k = 0; k < 4; ++k) least = std::min(least, std::abs(r[k] - r[(k + 1) % 4]));
    const auto is_one = [&](size_t k) {
      return r[k] != grid_.nothing() && r[k + 2] != grid_.nothing() &&
             std::abs(r[k] - r[k + 2]) <= kMostOfStep * least;
    };
    const size_t nearer = r[0] > r[1] ? 0 : 1;
    for (const size_t k : {nearer, 1 - nearer}) {
      if (is_one(k)) return static_cast<int>(k);
    }
    return std::nullopt;
  }

  // The side by which a contour leaves a cell that it enters by `side`; none: it ends there.
  std::optional<int> Next(GridCorner cell, int side) const {
    const int code = edges_.Code(cell.x, cell.y), others = code & ~(1 << side);
    if (std::has_single_bit(static_cast<unsigned>(others))) {
      return std::countr_zero(static_cast<unsigned>(others));
    }
    if (code != 0b1111) return std::nullopt;
    const std::optional<int> joined = FirstJoined(cell);
    if (!joined) return std::nullopt;
    // Around corner k, which is none of the two, are sides k − 1 and k.
    return *joined == 0 ? side ^ 1 : side ^ 3;
  }
  // Marks the edge of a cell's side; false: it was.
  bool Take(const Exit& exit) {
    const auto [x, y] = exit.cell;
    const uint32_t at_x = x + (exit.side == 1), at_y = y + (exit.side == 2);
    uint8_t& taken = taken_[size_t{at_y} * grid_.width() + at_x];
    const uint8_t bit = exit.side % 2 == 0 ? 1 : 2;
    if (taken & bit) return false;
    taken |= bit;
    return true;
  }

  // From within `exit.cell` outwards. Without a first cell it is a loop, or begins at the border.
  void Follow(Exit exit, std::optional<GridCorner> first_cell, bool from_border = false) {
    if (!Take(exit)) return;
    Contour contour{.gates = {}, .first_cell = first_cell};
    contour.is_closed = !first_cell && !from_border;
    while (true) {
      contour.gates.push_back(GateAt(exit));
      const GridCorner cell = Beyond(exit);
      if (!HasCell(cell)) break;
      const std::optional<int> side = Next(cell, Opposite(exit.side));
      if (!side) {
        contour.last_cell = cell;
        break;
      }
      exit = {cell, *side};
      if (!Take(exit)) break;  // back where the loop began
    }
    contours_.push_back(std::move(contour));
  }

  // Into `cell` through a side beyond which there is none.
  void FollowFromBorder(GridCorner cell, int side) {
    if (!Take({cell, side})) return;
    const ContourGate outwards = GateAt({cell, side});
    const ContourGate inwards{.left = outwards.right, .right = outwards.left};
    const std::optional<int> next = Next(cell, side);
    if (!next) {
      contours_.push_back({.gates = {inwards}, .last_cell = cell});
      return;
    }
    const Exit exit{cell, *next};
    const size_t count = contours_.size();
    Follow(exit, std::nullopt, true);
    if (contours_.size() == count) {
      contours_.push_back({.gates = {inwards}});
      return;
    }
    auto& gates = contours_.back().gates;
    gates.insert(gates.begin(), inwards);
  }

  const VolumeGrid& grid_;
  const EdgeMap& edges_;
  std::vector<uint8_t> taken_;  // a sample: bit 0 its edge to the right, bit 1 that below
  std::vector<Contour> contours_;
};

}  // namespace

std::vector<Contour> TraceContours(const VolumeGrid& grid, const EdgeMap& edges) {
  return Tracer(grid, edges).Trace();
}

}  // namespace penumbra
