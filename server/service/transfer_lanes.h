// Threads for blobs and archives, which take longer than a gRPC thread should be kept. None of them
// waits for a client: what a transfer has to do is posted whenever something of it has come.
//
//   TransferLanes transfers;
//   transfers.uploads().Post(identity.name, [this] { FinishBlob(); });
#pragma once

#include <vector>

#include "render/engine/worker_pool.h"
#include "server/fair_lane.h"

namespace penumbra {

class TransferLanes {
 public:
  // A blob at a time, which takes one core and then the disk: decoded, hashed and written.
  FairLane& uploads() { return uploads_; }
  // For exports and imports, a message of one of them at a time.
  FairLane& archives() { return archives_; }

  // Waits for the tasks that run, and drops those that do not yet.
  void Stop() {
    workers_.Stop();
    uploads_.Stop();
    archives_.Stop();
  }

 private:
  static constexpr int kUploads = 1;
  // A message may be the last of a long history, whose file is then read through: another archive
  // goes on meanwhile.
  static constexpr int kArchives = 2;

  WorkerPool workers_{std::vector<int>{kUploads, kArchives}};
  FairLane uploads_{workers_.lane(0)};
  FairLane archives_{workers_.lane(1)};
};

}  // namespace penumbra
