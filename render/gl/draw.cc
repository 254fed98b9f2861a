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

void SetCombine(Combine combine) {
  if (combine == Combine::kAdd || combine == Combine::kGreater) {
    glEnable(GL_BLEND);
    glBlendEquation(combine == Combine::kAdd ? GL_FUNC_ADD : GL_MAX);
    glBlendFunc(GL_ONE, GL_ONE);
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

}  // namespace

void Draw(Context& context, const DrawCall& call) {
  if (call.count <= 0 || call.instances <= 0 || !context.MakeCurrent().ok()) return;
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, call.target.name());
  SetArea(call);
  SetCombine(call.combine);
  glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glDisable(GL_CULL_FACE);
  if (call.depth_test == DepthTest::kNone) {
    glDisable(GL_DEPTH_TEST);
  } else {
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(call.depth_test == DepthTest::kNearer ? GL_GREATER : GL_GEQUAL);
  }
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
