// Keeps short what a device has been asked for and has not done, so that a stop is heard of soon.
//
//   pace.Start(context);
//   for (…) {
//     gl::Draw(…);   // of pace.most() units or less
//     if (auto status = pace.Did(context, units, stop); !status.ok()) return status;
//   }
#pragma once

#include <stop_token>

#include "absl/status/status.h"
#include "render/gl/context.h"

namespace penumbra::gl {

// Belongs to one context and one kind of work, whose units take about equally long. By the
// context's clock it finds out how many of them the device does in kTargetMs; without a clock it
// stays careful. How work is divided must not change what comes of it.
class WorkPace {
 public:
  static constexpr double kTargetMs = 20;

  // The most units to ask for at a time.
  double most() const { return most_; }

  // Nothing is under way.
  void Start(const Context& context);

  // So many units were asked for. Waits for the device once there are most() of them.
  //
  // Errors  kCancelled: stop requested; those of Context::Check
  absl::Status Did(Context& context, double units, const std::stop_token& stop);

 private:
  absl::Status Finish(Context& context, const std::stop_token& stop) const;
  void Learn(double elapsed_ms);

  // On a software device some 10 ms of triangles; within a few steps of what any device does.
  static constexpr double kFirst = 1 << 16, kLeast = 1 << 8, kMost = 1 << 26;

  double most_ = kFirst;
  double since_ = 0;  // units, since the device was waited for
  double began_ms_ = 0;
};

}  // namespace penumbra::gl
