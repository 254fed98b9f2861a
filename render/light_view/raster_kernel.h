// Drawing clusters of triangles into depths, compiled for several instruction sets and chosen when
// first called.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "render/math/vec.h"
#include "render/scene/alpha_mask.h"
#include "render/scene/triangle_clusters.h"

namespace penumbra {

// The most single-precision lanes that any instruction set here has; arrays are padded by as much.
inline constexpr size_t kRasterLanes = 16;

// Pixels from the image's first, either way, beyond which single precision is too little for
// corners: an edge is then off by up to a thousandth of a pixel.
inline constexpr float kMaxReach = 16384.0f;

// From a point of a view's frame to the image, in single precision.
struct RasterProjection {
  float scale_x, scale_y;    // pixels a slope, or a metre
  float offset_x, offset_y;  // of the window, in pixels
  float eye_x, eye_y, eye_z;
  float careful_depth;  // what is nearer is not drawn here
  bool from_infinity;
};

// `nearest` grows towards the eye: 1/z, from infinitely far −z. Rows follow each other without a
// gap; the last is followed by kRasterLanes more.
struct RasterImage {
  float* nearest;
  int32_t width;
  int32_t height;
};

// Vertices in the frame, an array for each coordinate, and three corners a triangle.
struct RasterCluster {
  const float* x;
  const float* y;
  const float* z;
  size_t vertex_count;  // at most 3 · kClusterTriangles
  const uint16_t* corners;
  size_t triangle_count;  // at most kClusterTriangles
};

// A cluster's vertices on the image. Where single precision is too little, x is beyond kMaxReach.
struct RasterVertices {
  static constexpr size_t kMost = 3 * kClusterTriangles + kRasterLanes;

  // x, y, −x, −y of each: the least of three corners' are all sides of their box.
  alignas(64) float corners[4 * kMost];
  alignas(64) float near[kMost];

  Vec2 At(size_t vertex) const { return Vec2(corners[4 * vertex], corners[4 * vertex + 1]); }
  bool IsWithinReach(size_t vertex) const {
    const Vec2 at = At(vertex);
    return std::abs(at.x) <= kMaxReach && std::abs(at.y) <= kMaxReach;
  }
};

// A number that is linear on the image.
struct LinearField {
  double at_origin = 0, per_column = 0, per_row = 0;

  double At(double x, double y) const { return at_origin + per_column * x + per_row * y; }
};

// What along a triangle's plane is linear on the image.
struct RasterPlanes {
  LinearField near;           // as RasterImage::nearest
  float least = 0, most = 0;  // between which `near` is at the triangle's own corners
  LinearField u, v;           // of a mask; from a point times `near`
};

// What has holes: a pixel is drawn where the mask is.
struct RasterCut {
  const AlphaMask* mask;
  float cutoff;
  bool from_infinity;
  const Vec2* uvs;           // of the mesh
  const uint32_t* vertices;  // of the mesh, for each of the cluster's
};

// Draws all triangles but those that reach beyond kMaxReach, or nearer than the careful depth:
// their places in the cluster are written to `deferred`, which has room for all. `vertices` is
// overwritten. Returns how many are deferred.
//
// cut  null: the cluster has no holes
size_t DrawCluster(const RasterCluster& cluster, const RasterProjection& projection,
                   const RasterImage& image, const RasterCut* cut, RasterVertices& vertices,
                   uint16_t* deferred);

// Draws one triangle of given corners, none beyond kMaxReach, whichever way it turns. A triangle
// that shares two of them with one of DrawCluster leaves no pixel out between them.
void DrawTriangle(const std::array<Vec2, 3>& corners, const RasterPlanes& planes,
                  const RasterImage& image, const RasterCut* cut);

}  // namespace penumbra
