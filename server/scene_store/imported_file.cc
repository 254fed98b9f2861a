#include "server/scene_store/imported_file.h"

#include <filesystem>
#include <utility>

#include "server/storage/durable_file.h"

namespace penumbra {

ImportedFile::ImportedFile(std::string scene_id, std::string path, DatabaseOptions options)
    : scene_id_(std::move(scene_id)),
      path_(std::move(path)),
      unfinished_(DataDirectory::UnfinishedPath(path_)),
      options_(options) {}

absl::StatusOr<std::unique_ptr<ImportedFile>> ImportedFile::Create(const DataDirectory& directory,
                                                                   const SceneIdentity& identity,
                                                                   const DatabaseOptions& options,
                                                                   const SceneState& start) {
  const auto number = directory.NextNumber(identity.scene_id);
  if (!number.ok()) return number.status();
  std::unique_ptr<ImportedFile> imported(new ImportedFile(
      identity.scene_id, directory.ScenePath(identity.scene_id, *number), options));
  auto file = SceneFile::Create(imported->unfinished_, identity, options, start);
  if (!file.ok()) return file.status();
  imported->file_ = *std::move(file);
  return imported;
}

ImportedFile::~ImportedFile() {
  if (file_) file_->Abandon();
  file_.reset();
  // What cannot be removed now is when the folder is opened again.
  for (const char* suffix : {"", "-wal", ".new", ".new-wal"}) {
    RemoveDurably(unfinished_ + suffix).IgnoreError();
  }
}

absl::StatusOr<std::unique_ptr<SceneFile>> ImportedFile::GiveName() {
  if (auto status = file_->Settle(); !status.ok()) return status;
  file_.reset();  // with everything in the file and none in its log
  // A log of an earlier file of this name is none of this one's.
  if (auto status = RemoveDurably(path_ + "-wal"); !status.ok()) return status;
  std::error_code error;
  std::filesystem::rename(unfinished_, path_, error);
  if (error) return FileError(path_, error.value());
  if (auto status = SyncFolder(std::filesystem::path(path_).parent_path()); !status.ok()) {
    return status;
  }
  auto file = SceneFile::Open(path_, options_);
  if (!file.ok()) return file;
  if (auto status = (*file)->Settle(); !status.ok()) return status;
  return file;
}

}  // namespace penumbra
