// Which commits are let in: no more than are on their way to the disk, in number, bytes and time.
//
//   if (auto status = AdmitCommit(request, of_scene, backlog, limits, now); !status.ok()) …
#pragma once

#include <cstddef>
#include <cstdint>

#include "absl/status/status.h"
#include "server/limits.h"
#include "server/request_shares.h"
#include "server/scene_store/commit_request.h"
#include "server/scene_store/storage_backlog.h"

namespace penumbra {

// What a scene has on its way to the disk.
struct SceneBacklog {
  size_t commits = 0;
  uint64_t bytes = 0;                             // of their requests
  StorageBacklog::Clock::time_point oldest_came;  // where there is one
};

// `request` is to the scene that `scene` is of, and `all` of all scenes. A principal may have half
// of what the others leave of limits.max_all_pending_commit_bytes: however many come, there is
// something left for the next.
//
// Errors  kResourceExhausted, each with a retry delay  QUOTA_PENDING: in number, of the scene;
//         QUOTA_PENDING_BYTES: of the scene, or of the principal; OVERLOADED: those that are on
//         their way have been for too long
absl::Status AdmitCommit(const CommitRequest& request, const SceneBacklog& scene,
                         const StorageBacklog& all, const ServerLimits& limits,
                         StorageBacklog::Clock::time_point now);

// Who sends a commit.
struct CommitSender {
  RequestShare share{};
  bool has_unanswered = false;  // other requests of the session have no answer yet
};

// `waited` is how long requests wait at present until they are read, and `lot` in [0, 1) is drawn
// for this one: as the wait comes near its limit, ever more are refused; of senders who send much
// less than others fewer; and of few who wait for answers before they send again none until it is
// four times the limit. They are told to wait for different times: those who were refused together
// would come back together.
//
// Errors  kResourceExhausted OVERLOADED, with a retry delay
absl::Status AdmitByReadDelay(StorageBacklog::Clock::duration waited, double lot,
                              const CommitSender& sender, const ServerLimits& limits);

}  // namespace penumbra
