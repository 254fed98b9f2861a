// The hard shadows of up to 64 light samples, drawn as one bit a texel and sample.
//
// GL's own rasteriser places vertices on a grid of as little as 1/16 of a texel, and clips in single
// precision: its shadow edges are off by more than rays can be told apart by. Here it only finds
// candidates. The vertex shader computes, in double precision, each triangle's three edges as
// functions that are linear in (column, row), and puts a slightly larger triangle around it; the
// fragment shader keeps the texels whose centres pass all three. Of a triangle that crosses the
// light's plane or the receiver's, the point that a texel sees decides.
//
// Source  Herf 1997, §3.2 and §3.5; edges in homogeneous coordinates after Olano and Greer 1997
#pragma once

#include "render/gl/program.h"
#include "render/math/vec.h"

namespace penumbra::texture_gl {

// Samples of one pass, a bit each. Of 32, 64 and 128 a pass, 64 were the quickest on llvmpipe: a
// pass over 65,536 texels took 0.077, 0.055 and 0.17 ms a sample.
inline constexpr int kSamplesPerPass = 64;

// What the vertex shader is told of the receiver (first) and of each sample, std140.
struct GpuPlane {
  DVec4 front{0.0};  // unit normal; w: the surface offset in metres
};
struct GpuSampleMap {
  // Rows of the map from offsets to (X, Y, 1) · w, X and Y in texels with centres at whole numbers;
  // w: what does not depend on the offset.
  DVec4 row_x{0.0}, row_y{0.0}, row_w{0.0};
  DVec4 light{0.0};  // x: the side of the receiver it is on, ±1; y: how high above it
};

// Where the shaders find the maps; the rest is where mesh_store.h says.
inline constexpr int kMapsBinding = 3;

// Uniforms: column0 … column3 of world_from_mesh, origin, heights (least and greatest of the
// instance's over the plane, with room for rounding), facing (±1, or 0: draw both sides),
// first_sample, size (of the receiver in texels), rows (first, count), slot (where in the target
// the first row's first texel is); for masked ones mask and least_alpha.
gl::ProgramSource OccluderProgram(bool masked);

}  // namespace penumbra::texture_gl
