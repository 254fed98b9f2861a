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

// The first that anyone settles on.
class Answer {
 public:
  void Settle(absl::StatusOr<std::shared_ptr<const Artifact>> value) {
    std::lock_guard lock(mutex_);
    if (!value_) value_ = std::move(value);
    came_.notify_all();
  }
  void Await() {
    std::unique_lock lock(mutex_);
    came_.wait(lock, [this] { return value_.has_value(); });
  }
  absl::StatusOr<std::shared_ptr<const Artifact>> Take() { return *std::move(value_); }

 private:
  std::mutex mutex_;
  std::condition_variable came_;
  std::optional<absl::StatusOr<std::shared_ptr<const Artifact>>> value_;
};

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

  Answer answer;
  auto subscription = engine.Subscribe(scene_id, spec, [&](const ArtifactUpdate& update) {
    const bool is_old = update.revision < wanted;
    if (!update.status.ok()) {
      if (!is_old || !DependsOnScene(update.status)) answer.Settle(update.status);
    } else if (!is_old && update.artifact->header.is_final) {
      answer.Settle(update.artifact);
    } else if (!is_old && options.progress) {
      options.progress(*update.artifact);
    }
  });
  if (!subscription.ok()) return subscription.status();
  const auto subscribed_to = engine.Snapshot(scene_id);
  if (!subscribed_to.ok()) return subscribed_to.status();
  // Another scene of this name by now, whose revisions began anew: it may never get to `wanted`.
  if ((*subscribed_to)->revision() < wanted) {
    subscription->reset();
    return ComputeOnce(engine, scene_id, spec, std::move(options));
  }
  const std::stop_callback on_stop(
      options.stop, [&] { answer.Settle(absl::CancelledError("stop was requested")); });
  answer.Await();
  subscription->reset();  // after this nobody touches `answer`
  return answer.Take();
}

}  // namespace penumbra
