// Final artifacts on disk, for the ResultCache of a server that keeps its scenes there: after a
// restart nothing has to be computed that was there before.
//
// A file holds one v1.ArtifactUpdate, as a client gets it that has nothing yet.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "absl/status/statusor.h"
#include "render/engine/result_cache.h"
#include "render/scene/scene_limits.h"
#include "server/log/logger.h"
#include "server/session/encoded_artifact.h"
#include "server/storage/result_files.h"

namespace penumbra {

struct StoredResultsOptions {
  std::string folder;
  uint64_t max_bytes = 0;
  std::string origin;  // see ResultOrigin: results of another one are not found
  SceneLimits limits{};
  // Only what has been the newest of its slot for so long is written: of a lamp that is dragged the
  // place where it comes to rest.
  std::chrono::milliseconds rest{2'000};
};

class StoredResults final : public ResultStore {
 public:
  // Errors  those of ResultFiles
  static absl::StatusOr<std::unique_ptr<StoredResults>> Open(const StoredResultsOptions& options,
                                                             Logger& logger);
  // Writes what waits, for a second at most.
  ~StoredResults() override;

  // Also null while another is being read.
  std::shared_ptr<const Artifact> Load(const ContentHash& key) override;
  void Save(const std::string& slot, const ContentHash& key,
            std::shared_ptr<const Artifact> artifact) override;

  uint64_t bytes() const { return files_->bytes(); }

 private:
  // What waits takes no more than this, the oldest giving way.
  static constexpr size_t kMaxWaitingBytes = size_t{64} << 20;
  using Clock = std::chrono::steady_clock;

  struct Waiting {
    std::string slot;
    ContentHash name;
    std::shared_ptr<const Artifact> artifact;
    size_t bytes = 0;
    Clock::time_point due;
  };

  StoredResults(const StoredResultsOptions& options, std::unique_ptr<ResultFiles> files,
                Logger& logger);
  ContentHash NameOf(const ContentHash& key) const;
  void WriteDue();
  void Write(const Waiting& result);
  // The lock is held.
  void Drop(std::list<Waiting>::iterator waiting);

  const StoredResultsOptions options_;
  const ContentHash origin_;  // kilobytes, hashed once and not for each name
  const std::unique_ptr<ResultFiles> files_;
  Logger& logger_;
  ArtifactEncoder encoder_;
  bool is_failing_ = false;  // of the writer alone
  std::mutex loading_;       // held while something is read

  std::mutex mutex_;  // guards the rest
  std::condition_variable changed_;
  std::list<Waiting> waiting_;  // the first is due first
  std::map<std::string, std::list<Waiting>::iterator> by_slot_;
  size_t waiting_bytes_ = 0;
  bool is_ending_ = false;
  std::thread writer_;
};

}  // namespace penumbra
