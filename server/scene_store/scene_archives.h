// Scenes as archives, out of a store and into it.
//
//   auto exported = archives.Export("studio", /*with_history=*/true);   // scene_export.h
//   auto imported = archives.Import("studio", blobs);                   // scene_import.h
#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "absl/status/statusor.h"
#include "server/scene_store/scene_export.h"
#include "server/scene_store/scene_import.h"
#include "server/scene_store/scene_store.h"

namespace penumbra {

// Any thread may use it, and each export and import one at a time. It outlives them, and the store
// it.
class SceneArchives {
 public:
  explicit SceneArchives(SceneStore& store) : store_(store) {}

  // Of the newest revision that is acknowledged. Where scenes live in memory there is no history.
  // Waits for the disk. Errors  those of SceneStore::Watch and of SceneExport
  absl::StatusOr<std::unique_ptr<SceneExport>> Export(const std::string& scene_id,
                                                      bool with_history);
  // Nobody else can make a scene of that id until it is over. `blobs` are those that the client may
  // name, and outlive it. The scene counts for `owner` from here on, unless nothing comes of it.
  // Errors  kInvalidArgument BAD_ID; kAlreadyExists; kResourceExhausted QUOTA_SCENES: of all, or
  //         of this owner
  absl::StatusOr<std::unique_ptr<SceneImport>> Import(const std::string& scene_id,
                                                      const SceneOwner& owner,
                                                      const BlobSource& blobs);

  // One of limits.archives.max_transfers, for as long as it is held.
  // Errors  kResourceExhausted QUOTA_ARCHIVES: all of them are held
  absl::StatusOr<std::shared_ptr<void>> TakeTurn();

 private:
  friend class SceneImport;
  absl::Status Reserve(const std::string& scene_id);
  // Whether or not there is a scene of it now.
  void Release(const std::string& scene_id);
  bool keeps_on_disk() const { return store_.storage_ != nullptr; }
  absl::StatusOr<std::unique_ptr<ImportedFile>> BeginFile(const std::string& scene_id,
                                                          const SceneState& start);
  // Lets the scene in. `file` is null where scenes live in memory.
  absl::Status Adopt(RestoredScene restored, ImportedFile* file);

  SceneStore& store_;
  std::mutex mutex_;
  uint32_t turns_taken_ = 0;
};

}  // namespace penumbra
