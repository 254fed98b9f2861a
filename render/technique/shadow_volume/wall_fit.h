// Contours made straight: walls along the light's rays between what is near and what is far.
//
//   AddWalls(grid, edges, mesh);
#pragma once

#include <vector>

#include "render/technique/shadow_volume/contour_trace.h"
#include "render/technique/shadow_volume/template_mesh.h"
#include "render/technique/shadow_volume/wall_sides.h"

namespace penumbra {

// Where a wall bends: a place on the image, and where the wall meets the surfaces at its left and
// right. A nearer one is met at its sample, so that walls begin on it; a further one at the place
// itself, which is where shadows end.
struct WallPost {
  struct End {
    DVec2 at{0.0};
    double nearness = 0;
  };
  DVec2 at;  // in the grid
  End left, right;
};

// Posts of a contour, the first repeated at the end of a closed one. The line between posts passes
// through each gate, at least kGateMargin of its length from either sample, and what its ends say
// of the surfaces is true at each gate to within kWallTolerance. Between these it is as long as
// going on from post to post allows.
std::vector<WallPost> FitWall(const VolumeGrid& grid, const EdgeMap& edges, const Contour& contour);
inline constexpr double kGateMargin = 0.05;

// Appends the walls of all contours, two triangles between posts. Where several meet in a cell
// their ends are the sides of a triangle, or of two, which are appended as well.
//
// Cost    about 0.2 µs an edge
// Source  McCool 2000, §8.1, which leaves the how to the reader
void AddWalls(const VolumeGrid& grid, const EdgeMap& edges, VolumeTriangles& mesh);

}  // namespace penumbra
