// What of a depth map walls can stand for: steps from one surface to another, one sample wide.
//
//   const VolumeGrid whole = WithoutHalfSteps(grid, edges);
//   const EdgeMap walls = WallEdges(whole, FindEdges(whole, {}));
#pragma once

#include "render/artifact/volume_grid.h"
#include "render/technique/shadow_volume/edge_map.h"

namespace penumbra {

// Those edges that are steps, and not slopes that change: a wall there would stand out of the
// surface, where triangles between samples lie on it.
EdgeMap WallEdges(const VolumeGrid& grid, const EdgeMap& edges);

// The grid without samples on the way from one surface down to another: where a sample has a step
// to either side, both the same way, it becomes as far as the further neighbour. What light grazes
// would else have two walls, whose heights are those of chance, and be shaded by them.
VolumeGrid WithoutHalfSteps(const VolumeGrid& grid, const EdgeMap& edges);

}  // namespace penumbra
