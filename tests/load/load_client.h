// One client of a load: a session that edits a scene on time, whatever the server does.
//
//   LoadClient client(address, "scene7", 12);
//   client.Open();
//   client.Commit(due);              // returns at once
//   client.AwaitAnswers(deadline);
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "penumbra/v1/service.grpc.pb.h"
#include "render/scene/scene.h"
#include "tests/load/message_stream.h"

namespace penumbra::load {

using Clock = std::chrono::steady_clock;

// A commit and what became of it.
struct SentCommit {
  SceneDelta delta;
  Clock::time_point due;
  Clock::time_point sent;
  Clock::time_point answered;  // the epoch: not at all
  Revision revision = 0;       // 0: not acknowledged
  std::string content_hash;
  std::string error;
};

class LoadClient {
 public:
  // On a connection of its own. `box` is the instance that it moves.
  LoadClient(const std::string& address, std::string scene_id, Instance box);
  ~LoadClient();

  absl::Status Open();
  // Moves the box somewhere else.
  void Commit(Clock::time_point due);
  void Commit(Clock::time_point due, SceneDelta delta);
  // Whether all commits were answered by then.
  bool AwaitAnswers(Clock::time_point deadline);
  // Whether its mirror is at that revision by then.
  bool AwaitRevision(Revision revision, Clock::time_point deadline);

  const std::string& scene_id() const { return scene_id_; }
  // Once nothing is under way any more.
  const std::vector<SentCommit>& commits() const { return commits_; }
  // What the session has told of the scene: revisions, each later than the one before.
  Revision told_revision() const;
  std::string told_hash() const;
  // An error that ended the session, or an update out of order.
  absl::Status status() const;

 private:
  using Stream = MessageStream<v1::SessionRequest, v1::SessionResponse>;

  void Receive(const v1::SessionResponse& response);
  void Receive(const v1::SceneUpdate& update);
  void End(const absl::Status& status);
  void Tell(Revision revision, const std::string& hash);

  const std::string scene_id_;
  const Instance box_;
  std::unique_ptr<v1::PenumbraService::Stub> stub_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool is_welcome_ = false;
  bool has_ended_ = false;
  bool is_awaited_ = false;  // somebody waits for a revision
  size_t answers_ = 0;
  std::vector<SentCommit> commits_;  // by commit id, which counts from 0
  Revision told_ = 0;
  std::string told_hash_;
  absl::Status status_;
  std::unique_ptr<Stream> stream_;  // last: its callbacks use the rest
};

}  // namespace penumbra::load
