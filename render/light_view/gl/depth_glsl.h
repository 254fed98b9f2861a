// Depth maps drawn by GL, a view at a time.
//
// GL's own rasteriser places vertices on a grid of as little as 1/16 of a pixel, and blends depths
// from there. Here it only finds candidates: the vertex shader works each triangle's edges and its
// plane out, in double precision, as functions that are linear on the image; the fragment shader
// keeps the pixels whose centres pass all three edges, and tells what the plane is there. A triangle
// that passes the eye needs no clipping: a pixel of which all three shares are ≥ 0 sees it in front.
//
// Source  edges in homogeneous coordinates after Olano and Greer 1997
#pragma once

#include "render/artifact/light_view.h"
#include "render/gl/program.h"
#include "render/math/vec.h"

namespace penumbra {

// What the shaders are told of a view, std140.
struct GpuDepthView {
  DVec4 origin{0.0};  // of the frame, in world space
  // From offsets to (x, y, 1) · w in pixels, centres at whole numbers; w: what does not depend on
  // the offset. w is the depth, or 1 from infinitely far.
  DVec4 row_x{0.0}, row_y{0.0}, row_w{0.0};
  // What is linear along a plane on the image, times w: 1, or −depth from infinitely far.
  DVec4 row_near{0.0};
  DVec4 limits{0.0};  // x: the near depth, where there is one, or else 0

  explicit GpuDepthView(const LightView& view);
};

inline constexpr int kDepthViewBinding = 3;

// Uniforms: column0 … column3 of world_from_mesh, size (of the image in pixels), rows (first and
// count, of those drawn); for masked ones mask and least_alpha. Writes 1/depth, or −depth from
// infinitely far, of which the greatest is the nearest.
gl::ProgramSource DepthProgram(bool masked);

}  // namespace penumbra
