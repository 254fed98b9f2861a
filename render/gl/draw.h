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

enum class DepthTest { kNone, kNearer, kNearerOrEqual, kEqual, kFarther };

// What becomes of the colour that is there.
enum class Combine {
  kReplace,
  kAdd,                 // floats
  kGreater,             // floats: the greater of both is kept, component by component
  kLess,                // likewise the less
  kOr,                  // whole numbers, bit by bit
  kAddColor,            // floats: RGB is added to, A left
  kAddColorTimesAlpha,  // RGB is added to by what is drawn times the A that is there, which is left
  kTakeFromAlpha,       // what is drawn is taken from A; RGB is left
  kMultiplyByAlpha,     // RGB is multiplied by the A that is there, which is then replaced
  kReplaceAlpha,        // RGB is left
};

// What is done to the stencil where the depth test passes, or where its value lets draw.
enum class Stencil {
  kNone,
  kInvert,      // its lowest bit is inverted
  kCount,       // triangles seen counter-clockwise add 1, others take 1, modulo 256
  kIncrement,   // all triangles add 1
  kOnce,        // drawn where it is 0, which it no longer is then
  kWhereIsSet,  // drawn where it is not 0; left
};

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
  Stencil stencil = Stencil::kNone;
  int first = 0;      // vertex, where there are no indices
  int instances = 1;  // times that all of it is drawn
  // Where clip space lies, and all that is drawn to. Empty: the whole target.
  PixelArea area{};
};

void Draw(Context& context, const DrawCall& call);

// Runs `groups` work groups of a compute program; what it wrote can be read afterwards.
void Dispatch(Context& context, const Program& program, uint32_t groups);

}  // namespace penumbra::gl
