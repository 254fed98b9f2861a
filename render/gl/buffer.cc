#include "render/gl/buffer.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "render/gl/gl.h"

namespace penumbra::gl {
namespace {

void Delete(uint32_t name) { glDeleteBuffers(1, &name); }

absl::Status CheckRange(size_t offset, size_t length, size_t size) {
  if (offset <= size && length <= size - offset) return absl::OkStatus();
  return absl::OutOfRangeError(absl::StrCat("gl::Buffer: found bytes ", offset, " to ",
                                            offset + length, ", need at most ", size));
}

}  // namespace

absl::StatusOr<Buffer> Buffer::Create(Context& context, size_t size) {
  auto buffer = Create(context, std::span<const std::byte>(static_cast<std::byte*>(nullptr), size));
  if (buffer.ok()) glClearNamedBufferData(buffer->name(), GL_R8, GL_RED, GL_UNSIGNED_BYTE, nullptr);
  return buffer;
}

absl::StatusOr<Buffer> Buffer::Create(Context& context, std::span<const std::byte> content) {
  if (absl::Status status = context.MakeCurrent(); !status.ok()) return status;
  auto memory = context.TakeMemory(content.size(), "gl::Buffer");
  if (!memory.ok()) return memory.status();
  GLuint name = 0;
  glCreateBuffers(1, &name);
  Buffer buffer;
  buffer.memory_ = *std::move(memory);
  buffer.name_ = ObjectName(context, name, &Delete);
  buffer.size_ = content.size();
  // GL refuses buffers of no bytes.
  glNamedBufferStorage(name, std::max<size_t>(1, content.size()), content.data(),
                       GL_DYNAMIC_STORAGE_BIT);
  if (absl::Status status = context.Check("gl::Buffer"); !status.ok()) return status;
  return buffer;
}

absl::Status Buffer::Write(Context& context, size_t offset, std::span<const std::byte> content) {
  if (absl::Status status = CheckRange(offset, content.size(), size_); !status.ok()) return status;
  if (absl::Status status = context.MakeCurrent(); !status.ok()) return status;
  if (!content.empty()) glNamedBufferSubData(name(), offset, content.size(), content.data());
  return absl::OkStatus();
}

absl::Status Buffer::Read(Context& context, size_t offset, std::span<std::byte> content) const {
  if (absl::Status status = CheckRange(offset, content.size(), size_); !status.ok()) return status;
  if (absl::Status status = context.MakeCurrent(); !status.ok()) return status;
  if (!content.empty()) glGetNamedBufferSubData(name(), offset, content.size(), content.data());
  return context.Check("gl::Buffer::Read");
}

void Buffer::BindStorage(Context& context, uint32_t binding) const {
  if (context.MakeCurrent().ok()) glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, name());
}

void Buffer::BindUniforms(Context& context, uint32_t binding) const {
  if (context.MakeCurrent().ok()) glBindBufferBase(GL_UNIFORM_BUFFER, binding, name());
}

}  // namespace penumbra::gl
