// The oracle of depth maps: the nearest of all triangles along a pixel's ray, in double precision.
//
//   const double expected = NearestDepth(view, x, y, OccluderTriangles(scene));
//   if (std::isnan(expected)) continue;   // rounding may decide
#pragma once

#include <vector>

#include "render/artifact/depth_map.h"
#include "render/reference/occluder_triangles.h"
#include "render/scene/scene.h"

namespace penumbra::testing {

// Infinity where nothing is met; NaN where the ray passes so near to an edge, to a mask's texel's,
// or to the near plane that rounding may decide.
double NearestDepth(const LightView& view, uint32_t x, uint32_t y,
                    const std::vector<OccluderTriangle>& triangles);

struct DepthComparison {
  size_t compared = 0;
  size_t differing = 0;  // by more than kDepthTolerance of the depth
  size_t seen = 0;       // something, of those compared
  double largest = 0;    // relative difference of those that do not differ
};

// Relative. Single precision alone makes a few 2⁻²⁴; a surface seen nearly from its edge more.
inline constexpr double kDepthTolerance = 2e-5;

// Whether two depths differ by no more than kDepthTolerance. `size` is added to what that is of:
// from infinitely far depths are about the middle of the scene.
bool AreSameDepth(double a, double b, double size = 0);

// How many pixels of two maps of one view are not the same depth.
size_t DifferingDepths(const DepthMap& a, const DepthMap& b);

DepthComparison CompareWithNearest(const DepthMap& map,
                                   const std::vector<OccluderTriangle>& triangles);

// Around each casting instance.
std::vector<Aabb> CasterBoxes(const Scene& scene);

}  // namespace penumbra::testing
