// A client's copy of a scene, kept up with the server's commits, its own and others'.
//
//   mirror.Push(scene_update);                 // the reader, in the order of the stream
//   mirror.PushOwn(delta, revision, hash);
//   auto scene = mirror.Newest();              // anyone: applies what is waiting
//
// Pushing never waits. Applying may, for meshes that have to be fetched.
#pragma once

#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <variant>

#include "absl/status/statusor.h"
#include "client/session/blob_transfer.h"
#include "penumbra/v1/session.pb.h"
#include "render/scene/scene.h"

namespace penumbra {

class MirroredScene {
 public:
  MirroredScene(const std::string& scene_id, BlobTransfer& blobs);

  void Push(v1::SceneUpdate update);
  void PushOwn(SceneDelta delta, Revision revision, std::string content_hash);

  // The newest scene, once all that was pushed is applied.
  //
  // Errors  kDataLoss: what was pushed does not fit together; those of fetching
  absl::StatusOr<std::shared_ptr<const Scene>> Newest();

  // The newest scene that is applied already. Never waits for the network.
  std::shared_ptr<const Scene> Applied() const;

  // Whether a first whole content has been pushed.
  bool has_content() const;
  // Where all that was pushed leads to, applied or not.
  Revision pushed_revision() const;

 private:
  struct OwnCommit {
    SceneDelta delta;
    Revision revision;
    std::string content_hash;
  };
  using Event = std::variant<v1::SceneUpdate, OwnCommit>;

  absl::Status Apply(const v1::SceneUpdate& update);
  absl::Status Apply(const OwnCommit& commit);
  absl::Status Check(const Scene& scene, const std::string& content_hash) const;
  void Publish(std::shared_ptr<const Scene> scene);

  BlobTransfer& blobs_;

  std::mutex applying_;  // held while events are applied; guards the next three
  absl::Status status_;
  std::shared_ptr<const Scene> next_;  // in the making
  bool is_continued_ = false;          // `next_` waits for the rest of a change

  mutable std::mutex mutex_;  // guards the rest
  std::deque<Event> events_;
  bool has_content_ = false;
  Revision pushed_revision_ = 0;  // where the events pushed so far lead to
  std::shared_ptr<const Scene> scene_;
};

}  // namespace penumbra
