// Pixels on their way from a framebuffer to memory, without waiting for what is drawn before them.
//
//   auto readback = gl::Readback::Start(context, target, {0, 0, 64, 64}, 1);
//   … draw something else …
//   auto pixels = readback->Wait(context);   // 64 · 64 floats, row 0 first
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "render/gl/buffer.h"
#include "render/gl/context.h"
#include "render/gl/draw.h"
#include "render/gl/framebuffer.h"

namespace penumbra::gl {

// A fence: it is passed when all that was asked of GL before is done.
class Readback {
 public:
  // Asks for the pixels of `area`; they go into a buffer of GL's own when their turn comes.
  //
  // Shapes  H×W pixels → H·W·channels floats
  // Errors  kInvalidArgument: `channels` is not 1 or 4; kResourceExhausted: out of memory
  static absl::StatusOr<Readback> Start(Context& context, const Framebuffer& from,
                                        const PixelArea& area, int channels);

  Readback(Readback&& other) noexcept;
  Readback& operator=(Readback&&) = delete;
  ~Readback();

  // Waits for the pixels. Errors  those of Context::Check
  absl::StatusOr<std::vector<float>> Wait(Context& context);

 private:
  Readback(Buffer buffer, size_t count) : buffer_(std::move(buffer)), count_(count) {}

  Buffer buffer_;
  size_t count_;
  void* fence_ = nullptr;  // GLsync
  std::shared_ptr<ContextLife> life_;
};

}  // namespace penumbra::gl
