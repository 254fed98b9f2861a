// Contours made straight: walls along the light's rays between what is near and what is far.
//
//   AddWalls(grid, edges, mesh);
#pragma once

#include <vector>

#include "render/technique/shadow_volume/contour_trace.h"
#include "render/technique/shadow_volume/template_mesh.h"

namespace penumbra {

// Where a wall bends: a place on the image, and the nearness of the surfaces at its left and right.
// The nearer one is met half a sample towards its own samples, so that walls begin on it and leave
// no gap; the further one at the place itself, which is where shadows end.
struct WallPost {
  DVec2 at;  // in the grid
  double left, right;
  DVec2 to_left{0.0};  // from sample to sample; 0 where several walls meet

  DVec2 left_at() const { return left > right ? at + kInset * to_left : at; }
  DVec2 right_at() const { return right > left ? at - kInset * to_left : at; }
  static constexpr double kInset = 0.5;
};

// Posts of a contour, the first repeated at the end of a closed one. The line between posts passes
// through each gate, at least kGateMargin of its length from either sample, and what its ends say
// of the surfaces is true at each gate to within kWallTolerance pixels' widths and as much of the
// surface's own slope. Between these it is as long as going on from post to post allows.
std::vector<WallPost> FitWall(const VolumeGrid& grid, const EdgeMap& edges, const Contour& contour);
inline constexpr double kGateMargin = 0.05;
inline constexpr double kWallTolerance = 1.0;

// Appends the walls of all contours, two triangles between posts. Where several walls meet, and
// where one ends in the open, they share a line on which their heights add up to nothing.
//
// The edges are those of the grid without half steps.
//
// Cost    about 0.2 µs an edge
// Source  McCool 2000, §8.1, which leaves the how to the reader
void AddWalls(const VolumeGrid& grid, const EdgeMap& edges, VolumeTriangles& mesh);

}  // namespace penumbra
