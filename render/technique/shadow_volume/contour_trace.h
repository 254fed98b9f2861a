// Edges of a depth map strung together: where shadow walls stand, before they are made straight.
//
//   for (const Contour& contour : TraceContours(grid, edges)) …
#pragma once

#include <optional>
#include <vector>

#include "render/artifact/volume_grid.h"
#include "render/technique/shadow_volume/edge_map.h"

namespace penumbra {

// Two neighbouring samples that a contour passes between, as seen along it: (x, y) on the way
// (0, 1) has (x, y) at its left and (x + 1, y) at its right.
struct ContourGate {
  GridCorner left, right;
};

// A way from cell to cell through gates. It begins and ends in the middle of a cell where not just
// two edges meet, or at a gate on the border of the surface; or it is closed, and no such cell is
// on it. Where four edges meet and two samples across the cell are of one surface, as of a thin one
// that runs aslant, two contours pass the cell and that surface is between them.
struct Contour {
  std::vector<ContourGate> gates;          // at least one
  std::optional<GridCorner> first_cell{};  // that it begins in; none: at the first gate
  std::optional<GridCorner> last_cell{};   // that it ends in; none: at the last gate
  bool is_closed = false;                  // the last gate is followed by the first
};

// Each edge of the surface is a gate of one contour, once.
//
// Cost  O(edges)
std::vector<Contour> TraceContours(const VolumeGrid& grid, const EdgeMap& edges);

}  // namespace penumbra
