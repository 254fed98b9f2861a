#include "render/engine/live_scene.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "render/engine/scene_change.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

absl::Status SceneHasEnded(const Scene& scene) {
  return FieldError(absl::StatusCode::kNotFound, "UNKNOWN_ID", "scene_id",
                    absl::StrCat("found '", scene.id(), "', which was deleted; need a scene's id"));
}

}  // namespace

std::shared_ptr<const Scene> LiveScene::Snapshot() const {
  std::lock_guard lock(head_mutex_);
  return head_;
}

absl::StatusOr<Revision> LiveScene::Commit(const SceneDelta& delta, const SceneLimits& limits) {
  std::lock_guard order(order_mutex_);
  const std::shared_ptr<const Scene> before = Snapshot();
  if (ended_) return SceneHasEnded(*before);
  auto applied = before->Apply(delta, limits);
  if (!applied.ok()) return applied.status();
  const std::shared_ptr<const Scene> after = *std::move(applied);
  {
    std::lock_guard lock(head_mutex_);
    head_ = after;
  }
  SceneChange change(*before, *after, delta);
  for (const auto& [key, channel] : channels_) channel->OnCommit(after, change);
  return after->revision();
}

absl::Status LiveScene::Subscribe(const ArtifactSpec& spec, const Technique& technique,
                                  const JobResources& resources, size_t max_channels,
                                  std::shared_ptr<Subscriber> subscriber) {
  std::lock_guard order(order_mutex_);
  if (ended_) return SceneHasEnded(*Snapshot());
  const std::string key = SpecKey(spec);
  auto found = channels_.find(key);
  if (found == channels_.end()) {
    if (channels_.size() >= max_channels) {
      return FieldError(absl::StatusCode::kResourceExhausted, "QUOTA_ARTIFACTS", "spec",
                        absl::StrCat("found ", channels_.size(),
                                     " different artifacts subscribed to, need at most ",
                                     max_channels, " a scene"));
    }
    found = channels_.emplace(key, std::make_shared<Channel>(spec, technique, resources)).first;
  }
  found->second->Add(std::move(subscriber), Snapshot());
  return absl::OkStatus();
}

void LiveScene::Unsubscribe(const ArtifactSpec& spec, const Subscriber* subscriber) {
  std::lock_guard order(order_mutex_);
  const auto found = channels_.find(SpecKey(spec));
  if (found != channels_.end() && found->second->Remove(subscriber)) channels_.erase(found);
}

void LiveScene::End(const absl::Status& reason) {
  std::lock_guard order(order_mutex_);
  ended_ = true;
  for (const auto& [key, channel] : channels_) channel->End(reason);
  channels_.clear();
}

}  // namespace penumbra
