#include "render/gl/work_pace.h"

#include <algorithm>

#include "render/gl/gl.h"

namespace penumbra::gl {

void WorkPace::Start(const Context& context) {
  since_ = 0;
  began_ms_ = context.NowMs();
}

absl::Status WorkPace::Did(Context& context, double units, const std::stop_token& stop) {
  if (stop.stop_requested()) return absl::CancelledError("stop requested");
  since_ += units;
  if (since_ < most_) return absl::OkStatus();
  if (absl::Status status = Finish(context, stop); !status.ok()) return status;
  if (context.has_clock()) Learn(context.NowMs() - began_ms_);
  Start(context);
  return absl::OkStatus();
}

absl::Status WorkPace::Finish(Context& context, const std::stop_token& stop) const {
  constexpr GLuint64 kTurnNs = 5'000'000;  // after each the stop is looked at
  if (absl::Status status = context.Check("gl::WorkPace"); !status.ok()) return status;
  const GLsync fence = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
  absl::Status status;
  while (status.ok() &&
         glClientWaitSync(fence, GL_SYNC_FLUSH_COMMANDS_BIT, kTurnNs) == GL_TIMEOUT_EXPIRED) {
    if (stop.stop_requested()) status = absl::CancelledError("stop requested");
    if (context.IsLost()) status = context.Check("gl::WorkPace");
  }
  glDeleteSync(fence);
  return status;
}

// By half or twice at most: a single measurement may be off.
void WorkPace::Learn(double elapsed_ms) {
  const double fitting = since_ * kTargetMs / std::max(elapsed_ms, 1e-3);
  most_ = std::clamp(std::clamp(fitting, most_ / 2, most_ * 2), kLeast, kMost);
}

}  // namespace penumbra::gl
