// The newest shadow of each pair of light and receiver, as updates bring them.
//
//   ShadowBoard board;
//   board.Follow(*engine, scene_id, specs);
//   board.WaitFor(revision, stop);
//   Draw(scene, board.shadows());
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/cli/draw_scene.h"
#include "client/session/remote_engine.h"

namespace penumbra {

// What came since the last commit.
struct ReceivedUpdates {
  uint64_t updates = 0;
  uint64_t bytes = 0;
  double first_ms = 0.0;  // steady clock, when the first artifact of the revision came
  double last_ms = 0.0;   // the same of the last final one
};

class ShadowBoard {
 public:
  // Errors  those of Subscribe
  absl::Status Follow(RemoteEngine& engine, const std::string& scene_id,
                      const std::vector<ArtifactSpec>& specs);

  // Waits until every shadow is final at `revision`, and says what that took.
  //
  // Errors  what an update said; kCancelled: stop requested
  absl::StatusOr<ReceivedUpdates> WaitFor(Revision revision, std::stop_token stop);

  Shadows shadows() const;

 private:
  struct Entry {
    ArtifactUpdate update;
    bool is_here = false;
  };
  void Receive(size_t index, const ArtifactUpdate& update, const UpdateTraffic& traffic);
  bool IsSettled(Revision revision) const;

  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::vector<Entry> entries_;
  ReceivedUpdates received_;
  Revision awaited_ = 0;
  // Destroyed first: no callback comes after that.
  std::vector<std::unique_ptr<Subscription>> subscriptions_;
};

}  // namespace penumbra
