#include "render/gl/draw.h"

#include "render/gl/gl.h"

namespace penumbra::gl {
namespace {

void SetArea(const DrawCall& call) {
  const PixelArea& area = call.area;
  if (area.width > 0 && area.height > 0) {
    glViewport(area.x, area.y, area.width, area.height);
    glEnable(GL_SCISSOR_TEST);
    glScissor(area.x, area.y, area.width, area.height);
  } else {
    glViewport(0, 0, call.target.options().width, call.target.options().height);
    glDisable(GL_SCISSOR_TEST);
  }
}

// How colours are blended; without `blends` they replace what is there.
struct Blending {
  bool blends = true;
  GLenum equation_rgb = GL_FUNC_ADD, equation_alpha = GL_FUNC_ADD;
  GLenum source_rgb = GL_ONE, target_rgb = GL_ONE;
  GLenum source_alpha = GL_ONE, target_alpha = GL_ONE;
};

Blending BlendingOf(Combine combine) {
  switch (combine) {
    case Combine::kReplace:
    case Combine::kOr:
      return {.blends = false};
    case Combine::kAdd:
      return {};
    case Combine::kGreater:
      return {.equation_rgb = GL_MAX, .equation_alpha = GL_MAX};
    case Combine::kLess:
      return {.equation_rgb = GL_MIN, .equation_alpha = GL_MIN};
    case Combine::kAddColor:
      return {.source_alpha = GL_ZERO};
    case Combine::kAddColorTimesAlpha:
      return {.source_rgb = GL_DST_ALPHA, .source_alpha = GL_ZERO};
    case Combine::kTakeFromAlpha:
      return {.equation_alpha = GL_FUNC_REVERSE_SUBTRACT, .source_rgb = GL_ZERO};
    case Combine::kMultiplyByAlpha:
      return {.source_rgb = GL_ZERO, .target_rgb = GL_DST_ALPHA, .target_alpha = GL_ZERO};
    case Combine::kReplaceAlpha:
      return {.source_rgb = GL_ZERO, .target_alpha = GL_ZERO};
  }
  return {.blends = false};
}

void SetCombine(Combine combine) {
  if (const Blending blending = BlendingOf(combine); blending.blends) {
    glEnable(GL_BLEND);
    glBlendEquationSeparate(blending.equation_rgb, blending.equation_alpha);
    glBlendFuncSeparate(blending.source_rgb, blending.target_rgb, blending.source_alpha,
                        blending.target_alpha);
  } else {
    glDisable(GL_BLEND);
  }
  if (combine == Combine::kOr) {
    glEnable(GL_COLOR_LOGIC_OP);
    glLogicOp(GL_OR);
  } else {
    glDisable(GL_COLOR_LOGIC_OP);
  }
}

void SetDepthTest(DepthTest test) {
  if (test == DepthTest::kNone) {
    glDisable(GL_DEPTH_TEST);
    return;
  }
  glEnable(GL_DEPTH_TEST);
  switch (test) {
    case DepthTest::kNone:
    case DepthTest::kNearer:
      return glDepthFunc(GL_GREATER);
    case DepthTest::kNearerOrEqual:
      return glDepthFunc(GL_GEQUAL);
    case DepthTest::kEqual:
      return glDepthFunc(GL_EQUAL);
    case DepthTest::kFarther:
      return glDepthFunc(GL_LESS);
  }
}

void SetStencil(Stencil stencil) {
  if (stencil == Stencil::kNone) {
    glDisable(GL_STENCIL_TEST);
    return;
  }
  glEnable(GL_STENCIL_TEST);
  const GLenum unset = stencil == Stencil::kOnce ? GL_EQUAL : GL_ALWAYS;
  glStencilFunc(stencil == Stencil::kWhereIsSet ? GL_NOTEQUAL : unset, 0, 0xff);
  glStencilMask(stencil == Stencil::kInvert ? 1 : 0xff);
  if (stencil == Stencil::kCount) {
    glFrontFace(GL_CCW);
    glStencilOpSeparate(GL_FRONT, GL_KEEP, GL_KEEP, GL_INCR_WRAP);
    glStencilOpSeparate(GL_BACK, GL_KEEP, GL_KEEP, GL_DECR_WRAP);
  } else {
    const bool increments = stencil == Stencil::kIncrement || stencil == Stencil::kOnce;
    const GLenum passed = increments ? GL_INCR_WRAP : GL_KEEP;
    glStencilOp(GL_KEEP, GL_KEEP, stencil == Stencil::kInvert ? GL_INVERT : passed);
  }
}

}  // namespace

void Draw(Context& context, const DrawCall& call) {
  if (call.count <= 0 || call.instances <= 0 || !context.MakeCurrent().ok()) return;
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, call.target.name());
  SetArea(call);
  SetCombine(call.combine);
  glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glDisable(GL_CULL_FACE);
  SetDepthTest(call.depth_test);
  SetStencil(call.stencil);
  glDepthMask(call.writes_depth ? GL_TRUE : GL_FALSE);
  const GLboolean color = call.writes_color ? GL_TRUE : GL_FALSE;
  glColorMask(color, color, color, color);
  glUseProgram(call.program.name());
  glBindVertexArray(call.vertices.name());
  if (call.vertices.has_indices()) {
    glDrawElementsInstanced(GL_TRIANGLES, call.count, GL_UNSIGNED_INT, nullptr, call.instances);
  } else {
    glDrawArraysInstanced(GL_TRIANGLES, call.first, call.count, call.instances);
  }
}

void Dispatch(Context& context, const Program& program, uint32_t groups) {
  if (groups == 0 || !context.MakeCurrent().ok()) return;
  glUseProgram(program.name());
  glDispatchCompute(groups, 1, 1);
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
}

}  // namespace penumbra::gl
