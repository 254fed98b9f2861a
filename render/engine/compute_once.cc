#include "render/engine/compute_once.h"

#include <condition_variable>
#include <mutex>
#include <optional>
#include <utility>

namespace penumbra {
namespace {

// Errors that a commit can mend; seen at an older revision they say nothing of the newest.
bool DependsOnScene(const absl::Status& status) {
  return absl::IsNotFound(status) || absl::IsFailedPrecondition(status) ||
         absl::IsInvalidArgument(status);
}

}  // namespace

absl::StatusOr<std::shared_ptr<const Artifact>> ComputeOnce(Engine& engine,
                                                            const std::string& scene_id,
                                                            const ArtifactSpec& spec,
                                                            ComputeOnceOptions options) {
  const auto snapshot = engine.Snapshot(scene_id);
  if (!snapshot.ok()) return snapshot.status();
  // Someone else may have subscribed to the same before the newest commit: what they got last is
  // delivered first.
  const Revision wanted = (*snapshot)->revision();

  std::mutex mutex;
  std::condition_variable came;
  std::optional<absl::StatusOr<std::shared_ptr<const Artifact>>> answer;
  const auto settle = [&](absl::StatusOr<std::shared_ptr<const Artifact>> value) {
    std::lock_guard lock(mutex);
    if (!answer) answer = std::move(value);
    came.notify_all();
  };
  auto subscription = engine.Subscribe(scene_id, spec, [&](const ArtifactUpdate& update) {
    const bool is_old = update.revision < wanted;
    if (!update.status.ok()) {
      if (!is_old || !DependsOnScene(update.status)) settle(update.status);
    } else if (!is_old && update.artifact->header.is_final) {
      settle(update.artifact);
    } else if (!is_old && options.progress) {
      options.progress(*update.artifact);
    }
  });
  if (!subscription.ok()) return subscription.status();
  const std::stop_callback on_stop(options.stop,
                                   [&] { settle(absl::CancelledError("stop was requested")); });
  {
    std::unique_lock lock(mutex);
    came.wait(lock, [&] { return answer.has_value(); });
  }
  subscription->reset();  // after this nobody touches `answer`
  return *std::move(answer);
}

}  // namespace penumbra
