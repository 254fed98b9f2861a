// The disk's side of one scene while a server has it: appends, and begins the file anew where that
// has failed.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <span>

#include "absl/status/statusor.h"
#include "server/storage/data_directory.h"
#include "server/storage/scene_file.h"

namespace penumbra {

struct SceneLogOptions {
  HistoryLimits history{};
  DatabaseOptions database{};
  // How often blobs that nothing needs are looked for, and how long they have been unused then.
  std::chrono::seconds house_interval{600};
};

// Any thread may use it; calls wait for one another, and for the disk.
class SceneLog {
 public:
  // `file` is settled.
  SceneLog(DataDirectory& directory, SceneLogOptions options, std::unique_ptr<SceneFile> file);

  const SceneIdentity& identity() const { return identity_; }

  // Returns once the commits are on disk; after an error none of them is.
  //
  // After an error of the disk it must not be asked again whether it has kept something: it may say
  // yes. The next call begins a new file with `whole`, which is everything that was acknowledged.
  // Errors  those of SceneFile
  absl::Status Append(std::span<const CommitRecord> commits,
                      const std::function<SceneState()>& whole);
  // Writes a snapshot of the head if one is due. Errors  those of SceneFile
  absl::Status Compact(const std::function<SnapshotRecord()>& snapshot);

  // As SceneFile's. Errors, further  kUnavailable STORAGE_FAILED: there is no file at the moment
  absl::StatusOr<SceneState> StateAt(Revision revision);
  absl::Status ForEachBody(const std::function<absl::Status(std::string_view)>& visit);

  // Removes the files. Nothing can be appended after that. Errors  kUnavailable STORAGE_FAILED
  absl::Status Remove();

 private:
  absl::Status BeginAnew(const SceneState& whole);
  absl::Status CheckFile() const;
  void Abandon();

  DataDirectory& directory_;
  const SceneLogOptions options_;
  const SceneIdentity identity_;

  std::mutex mutex_;
  std::unique_ptr<SceneFile> file_;  // null: writing has failed, or it is removed
  bool is_removed_ = false;
};

}  // namespace penumbra
