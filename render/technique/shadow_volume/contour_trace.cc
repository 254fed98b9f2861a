#include "render/technique/shadow_volume/contour_trace.h"

#include <bit>
#include <utility>

namespace penumbra {
namespace {

// Where a way leaves a cell: side 0 is to y − 1, side 1 to x + 1, side 2 to y + 1, side 3 to x − 1.
struct Exit {
  GridCorner cell;
  int side;
};

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

int EdgesAt(int code) { return std::popcount(static_cast<unsigned>(code)); }

class Tracer {
 public:
  Tracer(const VolumeGrid& grid, const EdgeMap& edges)
      : grid_(grid), edges_(edges), taken_(size_t{grid.width()} * grid.height()) {}

  std::vector<Contour> Trace() {
    edges_.ForEachCell([&](uint32_t x, uint32_t y, int code) {
      if (EdgesAt(code) == 2) return;
      for (int side = 0; side < 4; ++side) {
        if (code >> side & 1) Follow({{x, y}, side}, GridCorner{x, y});
      }
    });
    edges_.ForEachCell([&](uint32_t x, uint32_t y, int code) {
      for (int side = 0; side < 4; ++side) {
        if ((code >> side & 1) && !HasCell(Beyond({{x, y}, side}))) FollowFromBorder({x, y}, side);
      }
    });
    edges_.ForEachCell([&](uint32_t x, uint32_t y, int code) {
      Follow({{x, y}, std::countr_zero(static_cast<unsigned>(code))}, std::nullopt);
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
      const int code = edges_.Code(cell.x, cell.y);
      if (EdgesAt(code) != 2) {
        contour.last_cell = cell;
        break;
      }
      const int other = code & ~(1 << Opposite(exit.side));
      exit = {cell, std::countr_zero(static_cast<unsigned>(other))};
      if (!Take(exit)) break;  // back where the loop began
    }
    contours_.push_back(std::move(contour));
  }

  // Into `cell` through a side beyond which there is none.
  void FollowFromBorder(GridCorner cell, int side) {
    if (!Take({cell, side})) return;
    const ContourGate outwards = GateAt({cell, side});
    const ContourGate inwards{.left = outwards.right, .right = outwards.left};
    const int code = edges_.Code(cell.x, cell.y);
    if (EdgesAt(code) != 2) {
      contours_.push_back({.gates = {inwards}, .last_cell = cell});
      return;
    }
    const Exit exit{cell, std::countr_zero(static_cast<unsigned>(code & ~(1 << side)))};
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
