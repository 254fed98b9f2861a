// Parts of the shadow volume suite besides the tables.
#pragma once

#include <vector>

#include "tests/bench/bench.h"
#include "tests/support/stencil_masks.h"

namespace penumbra::bench {

// Edges and reconstruction against drawing the map of 200,000 triangles.
void AddRebuildRows(const BenchOptions& options, std::vector<Row>& rows);
// Walls fitted to contours against triangles between samples, on the scenes of the tables.
void AddVectorizedRows(const BenchOptions& options, std::vector<Row>& rows);
// One of 100 casters moves.
void AddPerObjectRows(const BenchOptions& options, std::vector<Row>& rows);
// Eyes anywhere in shadows, out of them and across their boundaries, towards the light among
// others; as the stencil has it.
void AddCameraRows(const BenchOptions& options, testing::StencilMasks& stencil,
                   std::vector<Row>& rows);

}  // namespace penumbra::bench
