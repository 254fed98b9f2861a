#include "render/gl/draw.h"

#include "render/gl/gl.h"

namespace penumbra::gl {

void Draw(Context& context, const DrawCall& call) {
  if (call.count <= 0 || !context.MakeCurrent().ok()) return;
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, call.target.name());
  glViewport(0, 0, call.target.options().width, call.target.options().height);
  glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glDisable(GL_CULL_FACE);
  glDisable(GL_BLEND);
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
    glDrawElements(GL_TRIANGLES, call.count, GL_UNSIGNED_INT, nullptr);
  } else {
    glDrawArrays(GL_TRIANGLES, 0, call.count);
  }
}

void Dispatch(Context& context, const Program& program, uint32_t groups) {
  if (groups == 0 || !context.MakeCurrent().ok()) return;
  glUseProgram(program.name());
  glDispatchCompute(groups, 1, 1);
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
}

}  // namespace penumbra::gl
