// The file of a scene that is being imported: it gets its name once it is whole, or goes.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "absl/status/statusor.h"
#include "server/storage/data_directory.h"
#include "server/storage/scene_file.h"

namespace penumbra {

class ImportedFile {
 public:
  // Errors, of all  those of SceneFile
  static absl::StatusOr<std::unique_ptr<ImportedFile>> Create(const DataDirectory& directory,
                                                              const SceneIdentity& identity,
                                                              const DatabaseOptions& options,
                                                              const SceneState& start);
  ~ImportedFile();

  absl::Status Append(std::span<const CommitRecord> commits) { return file_->Append(commits); }
  // Nothing can be appended after that. On an error there may be a file of that name.
  absl::StatusOr<std::unique_ptr<SceneFile>> GiveName();

  const std::string& scene_id() const { return scene_id_; }

 private:
  ImportedFile(std::string scene_id, std::string path, DatabaseOptions options);

  const std::string scene_id_;
  const std::string path_;        // that it is to have
  const std::string unfinished_;  // that it has
  const DatabaseOptions options_;
  std::unique_ptr<SceneFile> file_;
};

}  // namespace penumbra
