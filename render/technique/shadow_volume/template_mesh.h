// The boundary of a shadow as triangles between samples.
//
//   VolumeTriangles mesh;
//   AddTriangles(grid, edges, Reconstruction::kTemplate, mesh);
#pragma once

#include <cstdint>
#include <vector>

#include "render/artifact/volume_grid.h"
#include "render/technique/shadow_volume/edge_map.h"

namespace penumbra {

struct VolumeTriangles {
  std::vector<Vec4> vertices;     // homogeneous, world space
  std::vector<uint32_t> indices;  // counter-clockwise seen from the lit side
  // There would have been more than kMaxVolumeTriangles or kMaxVolumeVertices.
  bool is_cut_off = false;
};

// Which of a cell's two triangles there are, as bits 0 and 1, for a code and a split (1: along
// corners 1 and 3). Triangle 0 has side 0, triangle 1 side 2. A triangle is there if one of its
// sides is an edge; where the edge ends within the cell both are, so that edges reach a pixel
// further.
//
// Source  McCool 2000, §4, figure 5
int TemplateTriangles(int code, int split);

enum class Reconstruction : uint8_t {
  kTemplate,   // TemplateTriangles
  kFixedMesh,  // both triangles of each cell with an edge
  kAllCells,   // of every cell: what the others are parts of
};

// Appends, up to kMaxVolumeTriangles. Vertices are shared within a call; triangles of which nothing
// is near are left out.
void AddTriangles(const VolumeGrid& grid, const EdgeMap& edges, Reconstruction reconstruction,
                  VolumeTriangles& mesh);

}  // namespace penumbra
