#include "render/gl/readback.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "render/gl/gl.h"

namespace penumbra::gl {

absl::StatusOr<Readback> Readback::Start(Context& context, const Framebuffer& from,
                                         const PixelArea& area, int channels) {
  if (channels != 1 && channels != 4) {
    return absl::InvalidArgumentError(
        absl::StrCat("gl::Readback: found ", channels, " channels, need 1 or 4"));
  }
  const size_t count = size_t{1} * area.width * area.height * channels;
  auto buffer = Buffer::Create(context, count * sizeof(float));
  if (!buffer.ok()) return buffer.status();
  Readback readback(*std::move(buffer), count);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, from.name());
  glBindBuffer(GL_PIXEL_PACK_BUFFER, readback.buffer_.name());
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(area.x, area.y, area.width, area.height, channels == 1 ? GL_RED : GL_RGBA, GL_FLOAT,
               nullptr);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  readback.fence_ = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
  readback.life_ = context.life();
  glFlush();
  if (absl::Status status = context.Check("gl::Readback"); !status.ok()) return status;
  return readback;
}

Readback::Readback(Readback&& other) noexcept
    : buffer_(std::move(other.buffer_)),
      count_(other.count_),
      fence_(std::exchange(other.fence_, nullptr)),
      life_(std::move(other.life_)) {}

Readback::~Readback() {
  if (fence_ == nullptr || life_->context == nullptr) return;
  if (life_->context->MakeCurrent().ok()) glDeleteSync(static_cast<GLsync>(fence_));
}

absl::StatusOr<std::vector<float>> Readback::Wait(Context& context) {
  constexpr GLuint64 kTurnNs = 100'000'000;  // after each it is asked whether the context is lost
  if (absl::Status status = context.Check("gl::Readback::Wait"); !status.ok()) return status;
  while (glClientWaitSync(static_cast<GLsync>(fence_), GL_SYNC_FLUSH_COMMANDS_BIT, kTurnNs) ==
         GL_TIMEOUT_EXPIRED) {
    if (absl::Status status = context.Check("gl::Readback::Wait"); !status.ok()) return status;
  }
  std::vector<float> pixels(count_);
  absl::Status status = buffer_.Read(context, 0, std::as_writable_bytes(std::span<float>(pixels)));
  if (!status.ok()) return status;
  return pixels;
}

}  // namespace penumbra::gl
