// Drawing hard shadows into bitmaps, compiled for several instruction sets and chosen when first
// called.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/technique/soft_texture/shadow_bitmap.h"

namespace penumbra {

// The most single-precision lanes that any instruction set here has; arrays are padded by as much.
inline constexpr size_t kMaxLanes = 16;

// How far outside the texture, in texels, a triangle may reach and still be drawn in single
// precision: there an edge's position is good to 2⁻¹¹ of a texel.
inline constexpr float kGuardBand = 1024.0f;

// Below this w a vertex is so near the light that single precision would blur its shadow by more
// than a hundredth of a texel.
inline constexpr float kNearLightW = 1.0f / 64;

// Rows of the map from offsets to texels: X = width · x / w − ½ puts texel centres at whole
// numbers.
struct TexelProjection {
  float x_row[3];  // times the texture's width
  float y_row[3];  // times the texture's height
  float w_row[3];
};

// Vertices as drawn: columns X and rows Y in texels, and w.
struct ProjectedVertices {
  std::vector<float> x, y, w;

  void Reserve(size_t count) {
    if (x.size() >= count + kMaxLanes) return;
    for (auto* v : {&x, &y, &w}) v->resize(count + kMaxLanes);
  }
};

// Projects `count` offsets; inputs and outputs may be read and written up to kMaxLanes past the
// end.
void ProjectVertices(const float* x, const float* y, const float* z, size_t count,
                     const TexelProjection& projection, ProjectedVertices& out);

struct TriangleList {
  const uint32_t* corner0;
  const uint32_t* corner1;
  const uint32_t* corner2;
  const float* facing;  // see OccluderSet; null: draw both sides
  uint32_t count;
  uint32_t first_vertex;  // of the projected ones
};

// The texels that are drawn: all columns of rows [row_begin, row_end), of which `bitmap` holds just
// these.
struct TexelWindow {
  uint32_t width;
  uint32_t row_begin, row_end;
};

// Sets the bit of every texel whose centre a triangle covers.
//
// An edge covers up to and including its left end and up to but without its right end, rows
// likewise, all rounded up (Herf 1997, §4.3.1). An edge's position in a row is computed from its
// lower end whichever triangle asks, so that triangles that share an edge leave no gap.
//
// Triangles that reach out of the guard band, or nearer to the light than kNearLightW, are not
// drawn; their indices are appended to `deferred`. `near_light` says whether any vertex can be that
// near.
void DrawTriangles(const ProjectedVertices& vertices, const TriangleList& triangles,
                   const TexelWindow& window, bool near_light, ShadowBitmap& bitmap,
                   std::vector<uint32_t>& deferred);

// The instruction set in use, "AVX3" for instance.
const char* KernelTargetName();

}  // namespace penumbra
