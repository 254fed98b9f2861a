// Which buffers feed which inputs of a vertex shader.
//
//   auto vertices = gl::VertexArray::Create(context);
//   vertices->SetFloats(context, 0, positions, 3);   // layout(location = 0) in vec3 …
//   vertices->SetIndices(context, indices);
#pragma once

#include <cstdint>

#include "absl/status/statusor.h"
#include "render/gl/buffer.h"
#include "render/gl/context.h"

namespace penumbra::gl {

// The buffers must live as long as what is drawn from them.
class VertexArray {
 public:
  static absl::StatusOr<VertexArray> Create(Context& context);

  uint32_t name() const { return name_.get(); }
  bool has_indices() const { return has_indices_; }

  // Input `location` reads `components` (1 to 4) consecutive floats a vertex from `buffer`.
  void SetFloats(Context& context, uint32_t location, const Buffer& buffer, int components);
  // Vertices are drawn in the order of the 32-bit indices in `buffer`.
  void SetIndices(Context& context, const Buffer& buffer);

 private:
  ObjectName name_;
  bool has_indices_ = false;
};

}  // namespace penumbra::gl
