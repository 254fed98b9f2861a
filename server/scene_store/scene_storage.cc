#include "server/scene_store/scene_storage.h"

#include <chrono>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"
#include "server/scene_store/stored_scene.h"

namespace penumbra {
namespace {

// Transactions of different scenes that wait for the disk at a time.
constexpr int kWriters = 4;
// How much may be cut off unseen from files of scenes that were being edited when the power went.
constexpr std::chrono::seconds kHeadsInterval{1};

// The store's blobs, and those on disk that are not in it yet.
class LoadedBlobs : public BlobSource {
 public:
  explicit LoadedBlobs(BlobStore& store) : store_(store) {}

  std::shared_ptr<const Mesh> FindMesh(const ContentHash& hash) const override {
    if (!store_.Contains(hash)) store_.Load(hash).IgnoreError();
    return store_.FindMesh(hash);
  }
  std::shared_ptr<const AlphaMask> FindMask(const ContentHash& hash) const override {
    if (!store_.Contains(hash)) store_.Load(hash).IgnoreError();
    return store_.FindMask(hash);
  }

 private:
  BlobStore& store_;
};

absl::Status Damaged(const std::string& found) {
  return FieldError(absl::StatusCode::kDataLoss, "DAMAGED", "scene",
                    "found " + found + ", need it as it was written");
}

}  // namespace

absl::StatusOr<std::unique_ptr<SceneStorage>> SceneStorage::Open(const std::string& folder,
                                                                 const SceneLogOptions& options,
                                                                 Logger& logger) {
  auto directory = DataDirectory::Open(folder);
  if (!directory.ok()) return directory.status();
  std::unique_ptr<SceneStorage> storage(new SceneStorage(*std::move(directory), options, logger));
  if (auto status = storage->ReadHeadsFile(); !status.ok()) return status;
  // Which Restore is going to ask for: a folder that cannot be read is no folder without scenes.
  if (auto files = storage->directory_->SceneFiles(); !files.ok()) return files.status();
  storage->heads_writer_ = std::thread([raw = storage.get()] { raw->WriteHeadsLater(); });
  return storage;
}

SceneStorage::SceneStorage(std::unique_ptr<DataDirectory> directory, const SceneLogOptions& options,
                           Logger& logger)
    : directory_(std::move(directory)),
      options_(options),
      logger_(logger),
      blob_files_(directory_->blobs_path()),
      workers_({kWriters}) {}

SceneStorage::~SceneStorage() {
  workers_.Stop();
  {
    std::lock_guard lock(mutex_);
    is_ending_ = true;
  }
  noted_.notify_all();
  if (heads_writer_.joinable()) heads_writer_.join();
  if (are_heads_new_) WriteHeadsNow().IgnoreError();  // only the proof against cut files is older
}

absl::Status SceneStorage::ReadHeadsFile() {
  auto heads = ReadHeads(directory_->heads_path());
  if (absl::IsDataLoss(heads.status())) {
    // Scenes are taken as their own files have them.
    logger_.Error("heads_damaged", {{"error", std::string(heads.status().message())}});
    return absl::OkStatus();
  }
  if (!heads.ok()) return heads.status();
  heads_ = *std::move(heads);
  return absl::OkStatus();
}

std::vector<RestoredScene> SceneStorage::Restore(BlobStore& blobs, const SceneLimits& limits) {
  std::vector<RestoredScene> restored;
  const auto files = directory_->SceneFiles();
  if (!files.ok()) {
    logger_.Error("scenes_unreadable", {{"error", std::string(files.status().message())}});
  }
  KnownHeads without_file = heads_;
  if (files.ok()) {
    for (const auto& [scene_id, number] : *files) {
      without_file.erase(scene_id);
      restored.push_back(RestoreScene(scene_id, number, blobs, limits));
    }
  }
  for (const auto& [scene_id, known] : without_file) {
    restored.push_back({.scene_id = scene_id,
                        .status = Damaged(absl::StrCat("no file, where revision ", known.revision,
                                                       " was on disk"))});
  }
  for (const RestoredScene& scene : restored) {
    if (scene.status.ok()) {
      Note(*scene.log, scene.scene->revision());
    } else {
      // It is left as it is.
      logger_.Error("scene_refused",
                    {{"scene", scene.scene_id}, {"error", std::string(scene.status.message())}});
    }
  }
  return restored;
}

RestoredScene SceneStorage::RestoreScene(const std::string& scene_id, uint64_t number,
                                         BlobStore& blobs, const SceneLimits& limits) {
  RestoredScene restored{.scene_id = scene_id};
  const auto refuse = [&](absl::Status status) {
    restored.status = std::move(status);
    return std::move(restored);
  };
  auto file = SceneFile::Open(directory_->ScenePath(scene_id, number), options_.database);
  if (!file.ok()) return refuse(file.status());
  if ((*file)->identity().scene_id != scene_id) return refuse(Damaged("another scene's file"));
  if (auto status = CheckAgainstHeads(**file); !status.ok()) return refuse(status);
  if ((*file)->had_torn_tail()) {
    // As after a loss of power. What was in it was not acknowledged, or the heads would know.
    logger_.Warning("torn_transaction_dropped",
                    {{"scene", scene_id}, {"revision", (*file)->head().revision}});
  }
  const auto state = (*file)->StateAt((*file)->head().revision);
  if (!state.ok()) return refuse(state.status());
  auto answers = (*file)->Answers(options_.history);
  if (!answers.ok()) return refuse(answers.status());
  auto scene = SceneOf(scene_id, *state, LoadedBlobs(blobs), limits);
  if (!scene.ok()) return refuse(scene.status());
  // What has been read may be in the system's memory only; from here on others build on it.
  if (auto status = (*file)->Settle(); !status.ok()) return refuse(status);
  // Older ones are what is left of a time when writing failed.
  directory_->RemoveScene(scene_id, number).IgnoreError();
  restored.scene = *std::move(scene);
  restored.answers = *std::move(answers);
  restored.log = std::make_shared<SceneLog>(*directory_, options_, *std::move(file));
  return restored;
}

absl::Status SceneStorage::CheckAgainstHeads(const SceneFile& file) const {
  if (file.identity().owner != directory_->identity()) {
    return FieldError(absl::StatusCode::kFailedPrecondition, "FOREIGN", "scene",
                      "found the file of another server, need one that was imported");
  }
  const auto known = heads_.find(file.identity().scene_id);
  if (known == heads_.end()) return absl::OkStatus();
  if (known->second.incarnation != file.identity().incarnation) {
    return Damaged("the file of an earlier scene of this id");
  }
  if (known->second.revision > file.head().revision) {
    return Damaged(absl::StrCat("revision ", file.head().revision, ", where ",
                                known->second.revision, " was on disk"));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::shared_ptr<SceneLog>> SceneStorage::Create(const std::string& scene_id) {
  const SceneIdentity identity{
      .scene_id = scene_id, .incarnation = RandomBytes(16), .owner = directory_->identity()};
  // Not that of a file that could not be removed.
  const auto number = directory_->NextNumber(scene_id);
  if (!number.ok()) return number.status();
  auto file =
      SceneFile::Create(directory_->ScenePath(scene_id, *number), identity, options_.database);
  if (!file.ok()) return file.status();
  if (auto status = (*file)->Settle(); !status.ok()) return status;
  auto log = std::make_shared<SceneLog>(*directory_, options_, *std::move(file));
  Note(*log, 0);
  if (auto status = WriteHeadsNow(); !status.ok()) {
    Remove(*log).IgnoreError();
    return status;
  }
  return log;
}

absl::Status SceneStorage::Remove(SceneLog& log) {
  {
    std::lock_guard lock(mutex_);
    heads_.erase(log.identity().scene_id);
    are_heads_new_ = true;
  }
  // On a full disk there is no room for the heads before the files have gone.
  const absl::Status first = WriteHeadsNow();
  if (auto status = log.Remove(); !status.ok()) return status;
  return first.ok() ? first : WriteHeadsNow();
}

absl::Status SceneStorage::PutAside(const std::string& scene_id) {
  if (auto status = directory_->PutAside(scene_id); !status.ok()) return status;
  {
    std::lock_guard lock(mutex_);
    heads_.erase(scene_id);
    are_heads_new_ = true;
  }
  return WriteHeadsNow();
}

void SceneStorage::KeepHouse(std::function<void()> housekeeping) {
  std::lock_guard lock(mutex_);
  housekeeping_ = std::move(housekeeping);
}

void SceneStorage::Note(const SceneLog& log, Revision revision) {
  std::lock_guard lock(mutex_);
  if (is_ending_) return;
  heads_[log.identity().scene_id] = {.incarnation = log.identity().incarnation,
                                     .revision = revision};
  are_heads_new_ = true;
}

absl::Status SceneStorage::WriteHeadsNow() {
  std::lock_guard writing(writing_);
  KnownHeads heads;
  {
    std::lock_guard lock(mutex_);
    heads = heads_;
    are_heads_new_ = false;
  }
  const absl::Status status = WriteHeads(directory_->heads_path(), heads);
  if (!status.ok()) {
    std::lock_guard lock(mutex_);
    are_heads_new_ = true;  // to be tried again
  }
  return status;
}

void SceneStorage::WriteHeadsLater() {
  std::unique_lock lock(mutex_);
  auto kept_house = std::chrono::steady_clock::now();
  while (!noted_.wait_for(lock, kHeadsInterval, [this] { return is_ending_; })) {
    if (housekeeping_ && std::chrono::steady_clock::now() - kept_house >= options_.house_interval) {
      kept_house = std::chrono::steady_clock::now();
      lane().Post(housekeeping_);
    }
    if (!are_heads_new_) continue;
    lock.unlock();
    if (auto status = WriteHeadsNow(); !status.ok()) {
      logger_.Warning("heads_not_written", {{"error", std::string(status.message())}});
    }
    lock.lock();
  }
}

}  // namespace penumbra
