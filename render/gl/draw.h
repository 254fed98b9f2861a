// Drawing and computing. Each call states all it depends on; nothing is left over from the one
// before.
//
//   gl::Draw(context, {.program = program, .vertices = vertices, .target = target, .count = 36});
//
// Depth is reversed: 1 at the near plane, 0 infinitely far, in 32-bit floats, which spreads their
// precision evenly over relative distance. Clip-space z runs from 0 to w.
#pragma once

#include "render/gl/context.h"
#include "render/gl/framebuffer.h"
#include "render/gl/program.h"
#include "render/gl/vertex_array.h"

namespace penumbra::gl {

enum class DepthTest { kNone, kNearer, kNearerOrEqual };

// What becomes of the colour that is there: replaced, added to (floats), the greater of both kept
// (floats), or united with bit by bit (whole numbers).
enum class Combine { kReplace, kAdd, kGreater, kOr };

// Pixels of a target; `y` counts from the bottom.
struct PixelArea {
  int x = 0, y = 0, width = 0, height = 0;
};

struct DrawCall {
  const Program& program;
  const VertexArray& vertices;
  Framebuffer& target;
  int count = 0;  // indices, or vertices without them; triangles take three each
  DepthTest depth_test = DepthTest::kNearer;
  bool writes_depth = true;
  bool writes_color = true;
  Combine combine = Combine::kReplace;
  int first = 0;      // vertex, where there are no indices
  int instances = 1;  // times that all of it is drawn
  // Where clip space lies, and all that is drawn to. Empty: the whole target.
  PixelArea area{};
};

void Draw(Context& context, const DrawCall& call);

// Runs `groups` work groups of a compute program; what it wrote can be read afterwards.
void Dispatch(Context& context, const Program& program, uint32_t groups);

}  // namespace penumbra::gl
