// How long an export or an import may take, and one of the turns that they take.
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "render/scene/field_error.h"
#include "server/limits.h"
#include "server/scene_store/scene_archives.h"

namespace penumbra {

class ArchiveClock {
 public:
  // Errors  kResourceExhausted QUOTA_ARCHIVES
  absl::Status Start(SceneArchives& archives) {
    auto turn = archives.TakeTurn();
    if (turn.ok()) turn_ = *std::move(turn);
    return turn.status();
  }

  // Gives the turn back.
  void Finish() { turn_.reset(); }

  // Errors  kResourceExhausted QUOTA_ARCHIVE_SECONDS: it has taken too long
  absl::Status Check(const ServerLimits& limits) const {
    const std::chrono::seconds most = limits.archives.max_time;
    if (std::chrono::steady_clock::now() - start_ <= most) return absl::OkStatus();
    return FieldError(absl::StatusCode::kResourceExhausted, "QUOTA_ARCHIVE_SECONDS", "",
                      "found more than " + std::to_string(most.count()) +
                          " s of one export or import, need less");
  }

 private:
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::shared_ptr<void> turn_;
};

}  // namespace penumbra
