#include "server/scene_store/scene_storage.h"

#include <chrono>
#include <utility>

#include "server/random_bytes.h"

namespace penumbra {
namespace {

// Transactions of different scenes that wait for the disk at a time.
constexpr int kWriters = 8;
// Histories that are read at a time, and scenes that are made or deleted.
constexpr int kReaders = 2;
constexpr int kMakers = 2;
// How much may be cut off unseen from files of scenes that were being edited when the power went.
constexpr std::chrono::seconds kHeadsInterval{1};
// Takes turns with those who resume. No principal has this name.
constexpr char kHousekeeper[] = "";

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
      journals_(*directory_, options.database, logger),
      workers_({kWriters, kReaders, kMakers}),
      history_lane_(workers_.lane(1)),
      scenes_lane_(workers_.lane(2)) {}

void SceneStorage::Stop() {
  workers_.Stop();
  history_lane_.Stop();
  scenes_lane_.Stop();
}

SceneStorage::~SceneStorage() {
  Stop();
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

std::shared_ptr<SceneLog> SceneStorage::Log(std::unique_ptr<SceneFile> file) {
  auto log = std::make_shared<SceneLog>(*directory_, journals_, options_, std::move(file));
  std::lock_guard lock(mutex_);
  std::erase_if(logs_, [](const auto& weak) { return weak.expired(); });
  logs_.push_back(log);
  return log;
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
  auto log = Log(*std::move(file));
  Note(*log, 0);
  if (auto status = WriteHeadsNow(); !status.ok()) {
    Remove(*log).IgnoreError();
    return status;
  }
  return log;
}

absl::StatusOr<std::unique_ptr<ImportedFile>> SceneStorage::BeginImport(const std::string& scene_id,
                                                                        const SceneState& start) {
  // An incarnation of its own: clients of the scene that was exported may know of later revisions.
  const SceneIdentity identity{
      .scene_id = scene_id, .incarnation = RandomBytes(16), .owner = directory_->identity()};
  return ImportedFile::Create(*directory_, identity, options_.database, start);
}

absl::StatusOr<std::shared_ptr<SceneLog>> SceneStorage::Adopt(ImportedFile& imported) {
  auto file = imported.GiveName();
  if (!file.ok()) {
    directory_->RemoveScene(imported.scene_id(), 0).IgnoreError();
    return file.status();
  }
  const Revision revision = (*file)->head().revision;
  auto log = Log(*std::move(file));
  Note(*log, revision);
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
  const auto journals = KeptJournals(scene_id);
  if (!journals.ok()) return journals.status();
  if (auto status = directory_->PutAside(scene_id, *journals); !status.ok()) return status;
  // Nothing of it is lost.
  logger_.Info("scene_put_aside", {{"scene", scene_id}, {"journals", journals->size()}});
  {
    std::lock_guard lock(mutex_);
    kept_journals_.erase(scene_id);
    heads_.erase(scene_id);
    are_heads_new_ = true;
  }
  return WriteHeadsNow();
}

void SceneStorage::KeepHouse(std::chrono::seconds interval, std::function<void()> chore) {
  std::lock_guard lock(mutex_);
  chores_.push_back({.interval = interval, .task = std::move(chore)});
}

// With mutex_ locked.
void SceneStorage::PostChores() {
  const auto now = std::chrono::steady_clock::now();
  for (Chore& chore : chores_) {
    if (chore.is_under_way || now - chore.begun < chore.interval) continue;
    chore.begun = now;
    chore.is_under_way = true;
    history_lane_.Post(kHousekeeper, [this, &chore] { Do(chore); });
  }
}

void SceneStorage::Do(Chore& chore) {
  chore.task();
  std::lock_guard lock(mutex_);
  chore.is_under_way = false;
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

void SceneStorage::RestLogs() {
  std::vector<std::weak_ptr<SceneLog>> logs;
  {
    std::lock_guard lock(mutex_);
    logs = logs_;
  }
  for (const auto& weak : logs) {
    if (const auto log = weak.lock()) log->Rest();
  }
  std::lock_guard lock(mutex_);
  are_logs_resting_ = false;
}

void SceneStorage::WriteHeadsLater() {
  std::unique_lock lock(mutex_);
  while (!noted_.wait_for(lock, kHeadsInterval, [this] { return is_ending_; })) {
    PostChores();
    if (!std::exchange(are_logs_resting_, true)) lane().Post([this] { RestLogs(); });
    if (!are_heads_new_) continue;
    lock.unlock();
    if (auto status = WriteHeadsNow(); !status.ok()) {
      logger_.Warning("heads_not_written", {{"error", std::string(status.message())}});
    }
    lock.lock();
  }
}

}  // namespace penumbra
