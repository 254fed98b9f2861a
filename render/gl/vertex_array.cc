#include "render/gl/vertex_array.h"

#include "render/gl/gl.h"

namespace penumbra::gl {
namespace {

void Delete(uint32_t name) { glDeleteVertexArrays(1, &name); }

}  // namespace

absl::StatusOr<VertexArray> VertexArray::Create(Context& context) {
  if (absl::Status status = context.MakeCurrent(); !status.ok()) return status;
  GLuint name = 0;
  glCreateVertexArrays(1, &name);
  VertexArray array;
  array.name_ = ObjectName(context, name, &Delete);
  if (absl::Status status = context.Check("gl::VertexArray"); !status.ok()) return status;
  return array;
}

void VertexArray::SetFloats(Context& context, uint32_t location, const Buffer& buffer,
                            int components) {
  if (!context.MakeCurrent().ok()) return;
  glVertexArrayVertexBuffer(name(), location, buffer.name(), 0,
                            static_cast<GLsizei>(components * sizeof(float)));
  glVertexArrayAttribFormat(name(), location, components, GL_FLOAT, GL_FALSE, 0);
  glVertexArrayAttribBinding(name(), location, location);
  glEnableVertexArrayAttrib(name(), location);
}

void VertexArray::SetIndices(Context& context, const Buffer& buffer) {
  if (!context.MakeCurrent().ok()) return;
  glVertexArrayElementBuffer(name(), buffer.name());
  has_indices_ = true;
}

}  // namespace penumbra::gl
