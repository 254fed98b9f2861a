// A block of GPU memory.
//
//   auto buffer = gl::Buffer::Create(context, std::as_bytes(std::span(positions)));
//   buffer->BindStorage(context, 0);   // layout(std430, binding = 0) buffer …
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "absl/status/statusor.h"
#include "render/gl/context.h"

namespace penumbra::gl {

class Buffer {
 public:
  // A buffer of `size` bytes, zeroed. Errors  those of Context::TakeMemory and Context::Check
  static absl::StatusOr<Buffer> Create(Context& context, size_t size);
  // A buffer that holds `content`.
  static absl::StatusOr<Buffer> Create(Context& context, std::span<const std::byte> content);

  size_t size() const { return size_; }
  uint32_t name() const { return name_.get(); }

  // Errors  kOutOfRange: `content` does not fit at `offset`
  absl::Status Write(Context& context, size_t offset, std::span<const std::byte> content);
  absl::Status Read(Context& context, size_t offset, std::span<std::byte> content) const;
  void BindStorage(Context& context, uint32_t binding) const;
  // layout(std140, binding = …) uniform …, which may be as large as the shader's block or larger
  void BindUniforms(Context& context, uint32_t binding) const;

 private:
  MemoryBudget::Lease memory_;
  ObjectName name_;
  size_t size_ = 0;
};

}  // namespace penumbra::gl
