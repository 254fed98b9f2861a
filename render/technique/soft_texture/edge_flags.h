// Shadows filled from their edges: each edge leaves a flag in every row that it crosses, and a
// running sum along the row tells how many surfaces lie before a texel.
//
//   EdgeFlags flags(width, rows);
//   FlagTriangles(…, flags); FlagEdges(…, flags);
//   FillFromFlags(window, flags, bitmap);   // and the flags are clear again
//
// Source  Herf 1997, §4.3.1; departs: one dense plane of sums for the sample at hand instead of a
//         list of flags with light ids at every texel. A sample's flags then take 4 bytes a texel
//         whatever the scene, stay in the second-level cache, and are added up sixteen rows at a
//         time; with lists every flag was a cache miss of 12 bytes
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "render/technique/soft_texture/coverage_kernel.h"
#include "render/technique/soft_texture/shadow_bitmap.h"

namespace penumbra {

// What the number of surfaces before the sample (Appel's quantitative invisibility) changes by from
// a texel's left neighbour to it. Column by column, as in ShadowBitmap; left of column 0 counts as
// column 0.
struct EdgeFlags {
  EdgeFlags(uint32_t columns, uint32_t rows)
      : width(columns),
        stride(rows + ShadowBitmap::kRowPadding),
        change(size_t{columns} * stride, 0),
        rows_begin(rows),
        columns_begin(columns) {}

  void Touch(uint32_t column_begin, uint32_t column_end, uint32_t row_begin, uint32_t row_end) {
    rows_begin = std::min(rows_begin, row_begin);
    rows_end = std::max(rows_end, row_end);
    columns_begin = std::min(columns_begin, column_begin);
    columns_end = std::max(columns_end, column_end);
  }

  uint32_t width, stride;
  std::vector<int32_t> change;
  // All other rows and columns are zeros.
  uint32_t rows_begin, rows_end = 0;
  uint32_t columns_begin, columns_end = 0;
};

// Vertices as offsets from the receiver's origin; may be read kMaxLanes past the end.
struct VertexArrays {
  const float *x, *y, *z;
};

// Edges between vertices, `count` of them; may be read kMaxLanes past the end.
struct EdgeList {
  const uint32_t* from;
  const uint32_t* to;
  // Added where a row enters the region to the right of an edge that runs towards higher rows.
  const int32_t* weight;
  size_t count;
};

// Flags all rows of `window` that the edges cross. Where an edge crosses a row is computed as
// DrawTriangles does, so that the sums agree with what it fills.
//
// Every vertex must be within the guard band and at least kNearLightW from the light.
//
// `sign`  +1 or −1, multiplied into all weights
void FlagEdges(const VertexArrays& vertices, const EdgeList& edges, int32_t sign,
               const TexelProjection& projection, const TexelWindow& window, EdgeFlags& flags);

// The same for the left and right sides of triangles, as DrawTriangles draws them; `deferred` too.
void FlagTriangles(const ProjectedVertices& vertices, const TriangleList& triangles,
                   const TexelWindow& window, bool near_light, EdgeFlags& flags,
                   std::vector<uint32_t>& deferred);

// Sets the bit of every texel with a sum other than 0, and clears the flags.
void FillFromFlags(const TexelWindow& window, EdgeFlags& flags, ShadowBitmap& bitmap);

}  // namespace penumbra
