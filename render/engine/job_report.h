// How one job went, for whoever counts: an engine calls its JobObserver when a job has ended, on
// the job's thread. The call must not block. Times are by the engine's clock; without one all are
// 0.
#pragma once

#include <functional>
#include <optional>
#include <string_view>

#include "absl/status/status.h"

namespace penumbra {

struct JobReport {
  enum class Outcome {
    kFinished,    // published a final artifact
    kSuperseded,  // stopped for a newer revision, or because nobody follows the artifact any more
    kFailed,      // published `status`
  };

  std::string_view technique;  // its name, which lives as long as the program
  Outcome outcome = Outcome::kFinished;
  absl::Status status;
  bool was_known = false;  // the artifact was found, not computed
  double waited_ms = 0;    // for a thread
  double computed_ms = 0;  // from the thread's start to the last artifact or error
  // From the oldest commit, or subscription, that the job answers to its first and to its final
  // artifact; absent where it published none.
  std::optional<double> first_artifact_ms = std::nullopt;
  std::optional<double> final_artifact_ms = std::nullopt;
};

using JobObserver = std::function<void(const JobReport&)>;

}  // namespace penumbra
