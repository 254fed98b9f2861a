// GLSL that draws triangles as exactly as rays, whatever the driver's own rasteriser does.
#pragma once

#include <string>

namespace penumbra {

// For a vertex shader that draws a slightly larger triangle around one with its corners a, b, c in
// texels, centres at whole numbers, so that all texels it may cover get a fragment, which decides:
//
//   double Cross(dvec2 a, dvec2 b)
//   dvec2 LargerCorner(int k, dvec2 a, dvec2 b, dvec2 c)  // corner k of the larger one
//   bool SpansCenters(dvec2 a, dvec2 b, dvec2 c)          // false: it covers no texel's centre
std::string TriangleCoverGlsl();

// For a fragment shader: bool IsHoleAt(vec2 uv), as AlphaMask::At says, with the mask on kMaskUnit
// and its cutoff as the uniform least_alpha.
std::string AlphaMaskGlsl();

}  // namespace penumbra
