// A scene that changes: its newest snapshot, the order of its commits, and the channels that follow
// it.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "render/engine/channel.h"
#include "render/scene/scene.h"

namespace penumbra {

class LiveScene {
 public:
  explicit LiveScene(std::shared_ptr<const Scene> head) : head_(std::move(head)) {}

  // Waits for no commit, let alone for a job.
  std::shared_ptr<const Scene> Snapshot() const;

  // Errors  those of Scene::Apply; kNotFound: the scene has ended
  absl::StatusOr<Revision> Commit(const SceneDelta& delta, const SceneLimits& limits);

  // Makes `after`, which is the head with `delta` applied, the head.
  // Errors  kNotFound: the scene has ended; kAborted: there is another head by now
  absl::Status Publish(std::shared_ptr<const Scene> after, const SceneDelta& delta);

  // How many different specs may be followed.
  struct ChannelLimits {
    size_t of_scene;
    size_t in_all;
  };
  // `party` may be null. Errors  kNotFound: the scene has ended; kResourceExhausted QUOTA_ARTIFACTS
  absl::Status Subscribe(const ArtifactSpec& spec, const Technique& technique,
                         const JobResources& resources, const ChannelLimits& limits,
                         std::shared_ptr<Subscriber> subscriber, const Party* party);
  void Unsubscribe(const ArtifactSpec& spec, const Subscriber* subscriber);
  // Of a spec that is followed, see Channel; nothing where it is not.
  void Join(const ArtifactSpec& spec, const Party& party);
  void Leave(const ArtifactSpec& spec, const Party& party);

  // Errors  kNotFound: the scene has ended; kResourceExhausted: it has `max_viewers`
  absl::Status ReportView(const std::string& viewer, const std::optional<View>& view,
                          size_t max_viewers);

  // How much there is to do for it; as it last was, where a commit is under way.
  struct Load {
    size_t artifacts = 0;  // that somebody follows
    size_t jobs_waiting = 0;
    size_t jobs_running = 0;
  };
  Load load();

  // Says `reason`, if it is an error, to all subscribers as the last word, and cancels all jobs.
  void End(const absl::Status& reason);

 private:
  // With the order locked, as for all that follow.
  absl::StatusOr<std::shared_ptr<Channel>> MakeChannel(const ArtifactSpec& spec,
                                                       const Technique& technique,
                                                       const JobResources& resources,
                                                       const ChannelLimits& limits);
  void MakeHead(const Scene& before, std::shared_ptr<const Scene> after, const SceneDelta& delta);
  void ShareViews(Channel& channel, const Scene& scene) const;
  void ShareViews() const;

  const std::shared_ptr<SceneMemory> memory_ = std::make_shared<SceneMemory>();

  mutable std::mutex head_mutex_;  // held for a copy of the next two only
  std::shared_ptr<const Scene> head_;
  Load last_load_;

  std::mutex order_mutex_;  // one commit, subscription or end at a time; taken before head_mutex_
  bool ended_ = false;
  std::map<std::string, std::shared_ptr<Channel>> channels_;  // by SpecKey
  std::map<std::string, View> views_;                         // by viewer
};

}  // namespace penumbra
