// One subscription of a session: what has come for it, and whom to tell.
//
// The reader puts messages in; whichever thread runs the session's job takes the newest update out
// and calls back. An update that is not taken before the next one comes is left out.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "absl/status/status.h"
#include "client/session/remote_engine.h"
#include "client/session/traffic.h"
#include "penumbra/v1/artifact.pb.h"
#include "proto/convert/artifact_assembler.h"

namespace penumbra {

// What the server must hear once an update was dealt with.
struct Consumed {
  uint64_t link = 0;  // the connection on which it came
  uint64_t acknowledged_sequence = 0;
  uint32_t updates = 0;  // to give credit for; 0: nothing to say
};

class RemoteSubscriber {
 public:
  // `asked_at` is the newest revision that this client knew when it asked: what is said of the
  // subscription as a whole holds for that at least. `asked_ms` and all times are of the steady
  // clock.
  RemoteSubscriber(uint64_t id, RemoteEngine::MeasuredCallback callback, const SceneLimits& limits,
                   Revision asked_at, double asked_ms)
      : id_(id),
        asked_ms_(asked_ms),
        callback_(std::move(callback)),
        limits_(limits),
        assembler_(std::in_place, limits),
        newest_revision_(asked_at) {}

  uint64_t id() const { return id_; }

  // Takes a message in; by the reader alone. True if a job must Deliver(). `heard_ms` says when the
  // session heard of a revision.
  //
  // Errors  the server broke the protocol; the subscription must end
  absl::StatusOr<bool> Receive(const v1::ArtifactUpdate& message, double now_ms,
                               const std::function<double(Revision)>& heard_ms);

  // From here on messages come on connection `link`, from the start. Before any of them can come.
  void Restart(uint64_t link);

  // The last update there will be. True if a job must Deliver().
  bool ReceiveEnd(const absl::Status& reason);

  // Calls back with the newest update until none is waiting; `consumed` is told after each.
  void Deliver(const std::function<void(const Consumed&)>& consumed);

  // No callback runs after this; waits for one that does, unless it is the caller.
  void Close();

 private:
  bool Offer(ArtifactUpdate update);

  const uint64_t id_;
  const double asked_ms_;
  RemoteEngine::MeasuredCallback callback_;
  const SceneLimits limits_;
  std::optional<ArtifactAssembler> assembler_;  // the reader's; always there
  UpdateTraffic incoming_;                      // the reader's: of the update in the making

  std::mutex mutex_;  // guards the rest
  std::condition_variable idle_;
  std::optional<ArtifactUpdate> waiting_;
  UpdateTraffic waiting_traffic_;
  Consumed waiting_consumed_;
  Revision newest_revision_;
  bool is_scheduled_ = false;  // a job is going to look, or is looking, for what waits
  bool is_closed_ = false;
  std::thread::id caller_;  // the thread inside the callback; none: default
};

}  // namespace penumbra
