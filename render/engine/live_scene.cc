#include "render/engine/live_scene.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "render/engine/scene_change.h"
#include "render/scene/field_error.h"
#include "render/scene/retry_delay.h"

namespace penumbra {
namespace {

// Until others may have gone, and with them their artifacts.
constexpr double kRoomMayComeMs = 1'000;

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
  const Revision revision = (*applied)->revision();
  MakeHead(*before, *std::move(applied), delta);
  return revision;
}

absl::Status LiveScene::Publish(std::shared_ptr<const Scene> after, const SceneDelta& delta) {
  std::lock_guard order(order_mutex_);
  const std::shared_ptr<const Scene> before = Snapshot();
  if (ended_) return SceneHasEnded(*before);
  if (after->revision() != before->revision() + 1) {
    return FieldError(absl::StatusCode::kAborted, "STALE_BASE", "base_revision",
                      absl::StrCat("found ", after->revision() - 1, ", need the scene's revision ",
                                   before->revision()));
  }
  MakeHead(*before, std::move(after), delta);
  return absl::OkStatus();
}

void LiveScene::MakeHead(const Scene& before, std::shared_ptr<const Scene> after,
                         const SceneDelta& delta) {
  {
    std::lock_guard lock(head_mutex_);
    head_ = after;
  }
  SceneChange change(before, *after, delta);
  for (const auto& [key, channel] : channels_) channel->OnCommit(after, change);
  if (!delta.upsert_receivers.empty()) ShareViews();
}

absl::StatusOr<std::shared_ptr<Channel>> LiveScene::MakeChannel(const ArtifactSpec& spec,
                                                                const Technique& technique,
                                                                const JobResources& resources,
                                                                const ChannelLimits& limits) {
  if (channels_.size() >= limits.of_scene) {
    return FieldError(absl::StatusCode::kResourceExhausted, "QUOTA_ARTIFACTS", "spec",
                      absl::StrCat("found ", channels_.size(),
                                   " different artifacts subscribed to, need at most ",
                                   limits.of_scene, " a scene"));
  }
  auto channel = std::make_shared<Channel>(Snapshot()->id(), spec, technique, resources, memory_);
  if (const size_t count = *resources.channels; count > limits.in_all) {
    return WithRetryDelay(
        FieldError(
            absl::StatusCode::kResourceExhausted, "QUOTA_ARTIFACTS", "spec",
            absl::StrCat("found ", count, " different artifacts with this one, need at most ",
                         limits.in_all, " of all scenes")),
        kRoomMayComeMs);
  }
  return channel;
}

absl::Status LiveScene::Subscribe(const ArtifactSpec& spec, const Technique& technique,
                                  const JobResources& resources, const ChannelLimits& limits,
                                  std::shared_ptr<Subscriber> subscriber, const Party* party) {
  std::lock_guard order(order_mutex_);
  if (ended_) return SceneHasEnded(*Snapshot());
  const std::string key = SpecKey(spec);
  auto found = channels_.find(key);
  if (found == channels_.end()) {
    auto channel = MakeChannel(spec, technique, resources, limits);
    if (!channel.ok()) return channel.status();
    found = channels_.emplace(key, *std::move(channel)).first;
  }
  Channel& channel = *found->second;
  ShareViews(channel, *Snapshot());
  if (party) channel.Join(*party);
  channel.Add(std::move(subscriber), Snapshot());
  return absl::OkStatus();
}

void LiveScene::Join(const ArtifactSpec& spec, const Party& party) {
  std::lock_guard order(order_mutex_);
  const auto found = channels_.find(SpecKey(spec));
  if (found != channels_.end()) found->second->Join(party);
}

void LiveScene::Leave(const ArtifactSpec& spec, const Party& party) {
  std::lock_guard order(order_mutex_);
  const auto found = channels_.find(SpecKey(spec));
  if (found != channels_.end()) found->second->Leave(party);
}

void LiveScene::Unsubscribe(const ArtifactSpec& spec, const Subscriber* subscriber) {
  std::lock_guard order(order_mutex_);
  const auto found = channels_.find(SpecKey(spec));
  if (found != channels_.end() && found->second->Remove(subscriber)) channels_.erase(found);
}

absl::Status LiveScene::ReportView(const std::string& viewer, const std::optional<View>& view,
                                   size_t max_viewers) {
  std::lock_guard order(order_mutex_);
  if (ended_) return SceneHasEnded(*Snapshot());
  if (!view) {
    views_.erase(viewer);
  } else if (views_.size() >= max_viewers && !views_.contains(viewer)) {
    return FieldError(absl::StatusCode::kResourceExhausted, "QUOTA_VIEWERS", "viewer",
                      absl::StrCat("found ", views_.size(), " viewers, need fewer than ",
                                   max_viewers, " a scene before another"));
  } else {
    views_.insert_or_assign(viewer, *view);
  }
  ShareViews();
  return absl::OkStatus();
}

void LiveScene::ShareViews(Channel& channel, const Scene& scene) const {
  double share = 0;
  if (InfoOf(channel.spec().params).target != SpecTarget::kReceiver) {
    // It may show anywhere in everybody's picture.
    share = static_cast<double>(views_.size());
  } else if (!views_.empty()) {
    const auto receiver = scene.ResolveReceiver(channel.spec().receiver_id);
    if (receiver.ok()) {
      for (const auto& [viewer, view] : views_) share += ViewedShare(view, receiver->patch);
    }
  }
  channel.SetViewedShare(share);
}

void LiveScene::ShareViews() const {
  const auto scene = Snapshot();
  for (const auto& [key, channel] : channels_) ShareViews(*channel, *scene);
}

LiveScene::Load LiveScene::load() {
  const std::unique_lock order(order_mutex_, std::try_to_lock);
  if (!order.owns_lock()) {
    std::lock_guard lock(head_mutex_);
    return last_load_;
  }
  Load load{.artifacts = channels_.size()};
  for (const auto& [key, channel] : channels_) {
    const Channel::Load its = channel->load();
    load.jobs_waiting += its.waits ? 1 : 0;
    load.jobs_running += its.runs ? 1 : 0;
  }
  std::lock_guard lock(head_mutex_);
  last_load_ = load;
  return load;
}

void LiveScene::End(const absl::Status& reason) {
  std::lock_guard order(order_mutex_);
  ended_ = true;
  for (const auto& [key, channel] : channels_) channel->End(reason);
  channels_.clear();
}

}  // namespace penumbra
