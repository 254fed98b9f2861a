// One client of an overload: a session that edits a scene on time and waits for nothing, neither
// for answers nor for room to send. Where it is told to wait it does as the client library does: it
// keeps back what is due meanwhile. A deaf one sends everything all the same.
//
//   OpenClient client(address, "load7", box, /*is_deaf=*/false);
//   client.Open();
//   client.Commit(due);            // returns at once
//   auto sent = client.TakeRecords();
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

// What became of a commit that was due.
struct CommitRecord {
  enum class Fate { kUnanswered, kAccepted, kRefused, kHeld };
  Fate fate = Fate::kUnanswered;
  Clock::time_point due;
  Clock::time_point answered{};
  bool is_told_to_wait = false;  // refused, with a delay
};

class OpenClient {
 public:
  // On a connection of its own. `box` is the instance that it moves.
  OpenClient(const std::string& address, std::string scene_id, Instance box, bool is_deaf);

  absl::Status Open();
  void Commit(Clock::time_point due);
  bool AwaitAnswers(Clock::time_point deadline);
  // Those since the last call, with all answers that have come; later ones are lost.
  std::vector<CommitRecord> TakeRecords();

  const std::string& scene_id() const { return scene_id_; }
  // An error that ended the session.
  absl::Status status() const;

 private:
  using Stream = MessageStream<v1::SessionRequest, v1::SessionResponse>;

  v1::SessionRequest Move(uint64_t id) const;
  void Receive(const v1::SessionResponse& response);
  void Receive(const v1::CommitResult& result);  // with the lock held
  void End(const grpc::Status& status);

  const std::string scene_id_;
  const Instance box_;
  const bool is_deaf_;
  std::unique_ptr<v1::PenumbraService::Stub> stub_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool is_welcome_ = false;
  bool is_done_ = false;
  std::vector<CommitRecord> records_;  // by commit id less first_id_
  uint64_t first_id_ = 0;
  size_t open_ = 0;  // commits without an answer
  Clock::time_point wait_until_{};
  absl::Status status_;
  std::unique_ptr<Stream> stream_;  // last: its callbacks use the rest
};

}  // namespace penumbra::load
