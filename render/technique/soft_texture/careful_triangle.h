// The slow, exact way to draw one triangle: clipped in double precision, with its alpha mask.
#pragma once

#include <array>
#include <functional>

#include "render/math/vec.h"
#include "render/scene/alpha_mask.h"
#include "render/technique/soft_texture/coverage_kernel.h"
#include "render/technique/soft_texture/shadow_bitmap.h"

namespace penumbra {

// A triangle after the clip planes below. Each of the five adds one corner at most, were it not for
// rounding, with which an edge that lies in a plane may cross it to and fro: half as many again.
struct ClippedPolygon {
  static constexpr size_t kMaxCorners = 24;

  std::array<DVec2, kMaxCorners> texels;
  size_t size = 0;
};

// The corners of a triangle as (x, y, w) of ReceiverTransform.
using HomogeneousTriangle = std::array<DVec3, 3>;

// The part of the triangle before the light (w > 0) and within half a texture of [0, 1]² in u and
// v, in texels as TexelProjection has them.
ClippedPolygon ClipToTexture(const HomogeneousTriangle& triangle, double width, double height);

// Sets the bits of the texels whose centres `polygon` covers and for which `opaque(column, row)`
// holds. The rules are DrawTriangles'. `opaque` may be null: everywhere.
void FillPolygon(const ClippedPolygon& polygon, const TexelWindow& window,
                 const std::function<bool(uint32_t, uint32_t)>& opaque, ShadowBitmap& bitmap);

// The texture coordinates of the point where the ray through a texel centre meets the triangle.
//
// The ray from the light through (u, v) is the line of all multiples of (u, v, 1) in (x, y, w). It
// meets the triangle's plane at barycentric coordinates in proportion to E_k = (u, v, 1) · (P_{k+1}
// × P_{k+2}).
class UvAcrossTriangle {
 public:
  UvAcrossTriangle(const HomogeneousTriangle& triangle, const std::array<Vec2, 3>& uv, double width,
                   double height);

  Vec2 At(uint32_t column, uint32_t row) const;

 private:
  // Each is linear in (column, row, 1).
  DVec3 u_numerator_, v_numerator_, denominator_;
};

}  // namespace penumbra
