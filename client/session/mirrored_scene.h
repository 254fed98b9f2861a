// A client's copy of a scene, kept up with the server's commits, its own and others'.
//
//   if (mirror.Push(scene_update)) Post([&] { mirror.CatchUp(); });  // the reader, in order
//   mirror.PushOwn(delta, revision, hash);
//   auto scene = mirror.Newest();  // anyone: applies what is waiting
//
// Pushing never waits. Applying may, for meshes that have to be fetched.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
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

  // A change that comes in pieces is put together first: what lies between them may be no scene.
  // True if a job must CatchUp().
  bool Push(v1::SceneUpdate update);
  void PushOwn(SceneDelta delta, Revision revision, std::string content_hash);

  // The connection is another one: what had come of a change in pieces will come anew.
  void DropPieces();
  // Where all that was pushed leads to; what to resume from. None before a first whole content.
  struct Point {
    Revision revision = 0;
    std::string content_hash;
  };
  std::optional<Point> pushed_point() const;

  // Applies what is waiting until nothing is. One at a time: until it returns Push asks for none.
  void CatchUp();
  // Applies own commits, where nothing that may have to be fetched comes before them and nobody is
  // applying. Never waits.
  void CatchUpOwn();

  // Gives up what is being fetched, and fetches no more.
  void Stop() { stop_.request_stop(); }

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

  // With applying_ locked, as for the next two. False: nothing waits, or not one's own.
  bool ApplyNext(bool own_only);
  absl::Status Apply(const v1::SceneUpdate& update);
  absl::Status Apply(const OwnCommit& commit);
  absl::Status Publish(std::shared_ptr<const Scene> scene, const std::string& content_hash);

  BlobTransfer& blobs_;
  std::stop_source stop_;

  std::mutex applying_;  // held while events are applied; guards the next two
  absl::Status status_;
  absl::Status last_try_;  // kUnavailable: the oldest event waits for the server to be back

  mutable std::mutex mutex_;  // guards the rest
  std::deque<Event> events_;
  std::optional<v1::SceneUpdate> pieces_;  // of a change that goes on
  uint64_t pieces_bytes_ = 0;
  bool is_catching_up_ = false;  // a job is going to, or does
  bool has_content_ = false;
  Revision pushed_revision_ = 0;  // where the events pushed so far lead to
  std::string pushed_hash_;       // the content hash there
  std::shared_ptr<const Scene> scene_;
};

}  // namespace penumbra
