// What of a depth map walls can stand for: steps from one surface to another, one sample wide.
//
//   const EdgeMap walls = WallEdges(grid, FindEdges(grid, {}));
#pragma once

#include "render/artifact/volume_grid.h"
#include "render/technique/shadow_volume/edge_map.h"

namespace penumbra {

// Those edges that are steps, and not slopes that change: a wall there would stand out of the
// surface, where triangles between samples lie on it.
EdgeMap WallEdges(const VolumeGrid& grid, const EdgeMap& edges);

}  // namespace penumbra
