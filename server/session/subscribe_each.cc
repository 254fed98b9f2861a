// SubscribeEach: many subscriptions by one request, all of them or none.

#include <limits>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "proto/convert/spec_convert.h"
#include "proto/convert/status_convert.h"
#include "render/scene/field_error.h"
#include "render/scene/scene.h"
#include "server/session/session.h"

namespace penumbra {
namespace {

using Ids = google::protobuf::RepeatedPtrField<std::string>;

// `wanted`, or all of `table` where none is.
template <typename T>
absl::StatusOr<std::vector<std::string>> IdsAmong(const Ids& wanted, const Scene::Table<T>& table,
                                                  const char* field) {
  std::vector<std::string> ids(wanted.begin(), wanted.end());
  std::set<std::string> seen;
  for (size_t i = 0; i < ids.size(); ++i) {
    const std::string path = std::string(field) + "[" + std::to_string(i) + "]";
    if (auto status = CheckId(ids[i], path); !status.ok()) return status;
    if (!seen.insert(ids[i]).second) {
      return FieldError(absl::StatusCode::kInvalidArgument, "DUPLICATE_ID", path,
                        "found " + ids[i] + " a second time, need each id once");
    }
    if (!table.contains(ids[i])) {
      return FieldError(absl::StatusCode::kNotFound, "UNKNOWN_ID", path,
                        "found " + ids[i] + ", need one of the scene's");
    }
  }
  if (ids.empty()) {
    for (const auto& [id, object] : table) ids.push_back(id);
  }
  return ids;
}

// What each light's subscriptions are about: receivers, or, of a technique that computes for
// something else, an empty id.
absl::StatusOr<std::vector<std::string>> ReceiversOf(const v1::SubscribeEach& request,
                                                     SpecTarget target, const Scene& scene) {
  if (target == SpecTarget::kReceiver) {
    return IdsAmong(request.receiver_ids(), scene.receivers(), "receiver_ids");
  }
  if (request.receiver_ids().empty()) return std::vector<std::string>{""};
  return FieldError(absl::StatusCode::kInvalidArgument, "UNEXPECTED_FIELD", "receiver_ids",
                    "found some, need none for this technique");
}

}  // namespace

void Session::OnSubscribeEach(const v1::SubscribeEach& request) {
  const auto reply = std::make_shared<Reply>();
  v1::SubscribeEachResult& result = *reply->response.mutable_subscribe_each_result();
  result.set_first_subscription_id(request.first_subscription_id());
  auto feeds = MakeFeeds(request, result);
  if (!feeds.ok()) {
    result.clear_light_ids();
    result.clear_receiver_ids();
    *result.mutable_error() = ToProto(feeds.status());
    record_->Refuse("subscribe_each", feeds.status());
  }
  {
    // The feeds and the reply at once: no update may go out before the reply.
    std::lock_guard lock(mutex_);
    replies_.push_back(reply);
    ++unsent_subscribe_results_;
    if (feeds.ok()) {
      services_.counters.open_subscriptions += feeds->size();
      record_->CountSubscriptions(static_cast<int64_t>(feeds->size()));
      for (auto& feed : *feeds) {
        const uint64_t id = feed->id();
        feeds_[id] = std::move(feed);
      }
    }
  }
  wake_();
}

absl::Status Session::CheckRoom(uint64_t first_id, uint64_t count) const {
  std::lock_guard lock(mutex_);
  const uint64_t most = services_.limits.max_subscriptions_per_session;
  if (count > most || feeds_.size() + count > most) {
    return FieldError(absl::StatusCode::kResourceExhausted, "QUOTA_SUBSCRIPTIONS", "subscribe_each",
                      "found " + std::to_string(count) + " to make with " +
                          std::to_string(feeds_.size()) + " open, need at most " +
                          std::to_string(most) + " in all");
  }
  if (first_id > std::numeric_limits<uint64_t>::max() - count) {
    return FieldError(
        absl::StatusCode::kInvalidArgument, "RANGE", "first_subscription_id",
        "found " + std::to_string(first_id) + ", need room above it for " + std::to_string(count));
  }
  const auto taken = feeds_.lower_bound(first_id);
  if (taken != feeds_.end() && taken->first - first_id < count) {
    return FieldError(absl::StatusCode::kAlreadyExists, "DUPLICATE_ID", "first_subscription_id",
                      "found " + std::to_string(taken->first) + " open, need " +
                          std::to_string(count) + " free ids from the first on");
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<std::unique_ptr<SubscriptionFeed>>> Session::MakeFeeds(
    const v1::SubscribeEach& request, v1::SubscribeEachResult& result) {
  const auto scene = services_.scenes.Snapshot(scene_id_);
  if (!scene.ok()) return scene.status();
  const auto lights = IdsAmong(request.light_ids(), (*scene)->lights(), "light_ids");
  if (!lights.ok()) return lights.status();
  const auto target = TargetOf(request.technique());
  if (!target.ok()) return target.status();
  const auto receivers = ReceiversOf(request, *target, **scene);
  if (!receivers.ok()) return receivers.status();
  const uint64_t first_id = request.first_subscription_id();
  if (auto status = CheckRoom(first_id, lights->size() * receivers->size()); !status.ok()) {
    return status;
  }
  result.mutable_light_ids()->Assign(lights->begin(), lights->end());
  result.mutable_receiver_ids()->Assign(receivers->begin(), receivers->end());

  std::vector<std::unique_ptr<SubscriptionFeed>> feeds;
  v1::ArtifactSpec proto = request.technique();
  for (const std::string& receiver_id : *receivers) {
    for (const std::string& light_id : *lights) {
      proto.set_light_id(light_id);
      proto.set_receiver_id(receiver_id);
      const auto spec = FromProto(proto);
      absl::Status status = spec.status();
      if (status.ok()) {
        auto feed = Follow(first_id + feeds.size(), *spec, request.initial_credit());
        if (feed.ok()) feeds.push_back(*std::move(feed));
        status = feed.status();
      }
      if (status.ok()) continue;
      for (auto& feed : feeds) feed->stream().RemoveListener(this);
      return status;
    }
  }
  return feeds;
}

}  // namespace penumbra
