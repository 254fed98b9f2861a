// The folder that a server keeps its scenes in, for as long as it runs.
//
//   FORMAT   what the folder is, and the data's identity      LOCK   held by the server that has it
//   heads    how far each scene had come at some time         scenes/ID~N.db, blobs/HH/HASH
//   owners   who made which scene                             journals/N.db, results/HASH
//
// A scene's file is begun anew, as the next N, where writing to it has failed: what the system then
// says it holds is not to be relied on.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"

namespace penumbra {

class DataDirectory {
 public:
  // Takes the folder; makes it, and what is in it, where the folder that it lies in is there.
  //
  // Errors  kFailedPrecondition  DATA_DIR: no folder, one that is a link, of another user or not
  //         writable; DATA_DIR_LOCKED: another server has it; NEWER_FORMAT; DATA_DIR_FOREIGN: there
  //         are other things in it. All name --data-dir, and what is in the folder is as it was.
  static absl::StatusOr<std::unique_ptr<DataDirectory>> Open(const std::string& path);
  ~DataDirectory();
  DataDirectory(const DataDirectory&) = delete;
  DataDirectory& operator=(const DataDirectory&) = delete;

  // 16 random bytes, made with the folder.
  const std::string& identity() const { return identity_; }

  std::string heads_path() const { return path_ + "/heads"; }
  std::string owners_path() const { return path_ + "/owners"; }
  std::string blobs_path() const { return path_ + "/blobs"; }
  std::string results_path() const { return path_ + "/results"; }  // made by whoever needs it
  std::string ScenePath(const std::string& scene_id, uint64_t number) const;
  // The newest file of each scene that has one: its number, by the scene's id.
  absl::StatusOr<std::map<std::string, uint64_t>> SceneFiles() const;
  // Of the next file of a scene: one that none of its files has. 1 where there is none.
  absl::StatusOr<uint64_t> NextNumber(const std::string& scene_id) const;
  // Of a file that is to become one of these once it is whole. What a crash has left of such files
  // is removed when the folder is opened.
  static std::string UnfinishedPath(const std::string& scene_path) {
    return scene_path + ".import";
  }
  // Journals that are there, the oldest first, and the number of the next one.
  std::string JournalPath(uint64_t number) const;
  absl::StatusOr<std::vector<uint64_t>> Journals() const;
  absl::StatusOr<uint64_t> NextJournal() const;
  absl::Status RemoveJournal(uint64_t number) const;
  // Where the log of a journal that has been removed waits for the next one.
  std::string SpareJournalPath() const { return path_ + "/journals/spare"; }
  // Removes the files of a scene but the one of this number; 0: all of them.
  absl::Status RemoveScene(const std::string& scene_id, uint64_t kept);
  // Moves a scene's files to `removed/`, under names that tell when. These journals are there as
  // well from then on, and stay where they are.
  absl::Status PutAside(const std::string& scene_id, std::span<const uint64_t> journals = {});

 private:
  DataDirectory(std::string path, int lock) : path_(std::move(path)), lock_(lock) {}
  absl::Status Prepare();
  absl::Status MakeFolders() const;
  absl::Status RemoveUnfinished() const;
  absl::StatusOr<std::map<std::string, std::vector<uint64_t>>> AllSceneFiles() const;

  const std::string path_;
  const int lock_;
  std::string identity_;
};

}  // namespace penumbra
