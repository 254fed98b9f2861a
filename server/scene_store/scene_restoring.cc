// What a storage finds when a server starts: scenes' files, and journals with their newest commits.

#include <filesystem>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"
#include "server/scene_store/scene_storage.h"
#include "server/scene_store/stored_scene.h"
#include "server/storage/scene_rows.h"

namespace penumbra {
namespace {

// A link will not be a file some day, as a disk that fails may be read.
absl::StatusOr<std::unique_ptr<SceneFile>> OpenFound(const std::string& path,
                                                     const DatabaseOptions& options) {
  std::error_code ignored;
  if (std::filesystem::is_symlink(path, ignored)) return Damaged("a link, not a file");
  return SceneFile::Open(path, options);
}

// The store's blobs, and those on disk that are not in it yet.
class LoadedBlobs : public BlobSource {
 public:
  explicit LoadedBlobs(BlobStore& store) : store_(store) {}

  std::shared_ptr<const Mesh> FindMesh(const ContentHash& hash) const override {
    Load(hash);
    return store_.FindMesh(hash);
  }
  std::shared_ptr<const AlphaMask> FindMask(const ContentHash& hash) const override {
    Load(hash);
    return store_.FindMask(hash);
  }
  // Why one that may be there and sound could not be read.
  const absl::Status& failed() const { return failed_; }

 private:
  void Load(const ContentHash& hash) const {
    if (store_.Contains(hash)) return;
    const absl::Status status = store_.Load(hash);
    if (absl::IsUnavailable(status) || absl::IsResourceExhausted(status)) failed_ = status;
  }

  BlobStore& store_;
  mutable absl::Status failed_;
};

}  // namespace

std::vector<RestoredScene> SceneStorage::Restore(BlobStore& blobs, const SceneLimits& limits) {
  std::vector<RestoredScene> restored;
  const auto files = directory_->SceneFiles();
  if (!files.ok()) {
    logger_.Error("scenes_unreadable", {{"error", std::string(files.status().message())}});
  }
  const FoundJournals journals = ReadJournals();
  KnownHeads without_file = heads_;
  if (files.ok()) {
    for (const auto& [scene_id, number] : *files) {
      without_file.erase(scene_id);
      restored.push_back(RestoreScene(scene_id, number, journals, blobs, limits));
    }
  }
  for (const auto& [scene_id, known] : without_file) {
    // Its file may be elsewhere, and name any journal.
    restored.push_back({.scene_id = scene_id,
                        .status = files.ok() ? Damaged(absl::StrCat("no file, where revision ",
                                                                    known.revision, " was on disk"))
                                             : files.status()});
  }
  Tell(restored);
  if (files.ok() && journals.are_known()) RemoveJournals(journals, restored);
  return restored;
}

std::vector<RestoredScene> SceneStorage::RestoreAgain(const std::vector<std::string>& scene_ids,
                                                      BlobStore& blobs, const SceneLimits& limits) {
  std::vector<RestoredScene> restored;
  const auto files = directory_->SceneFiles();
  if (!files.ok()) return restored;
  for (const std::string& scene_id : scene_ids) {
    const auto file = files->find(scene_id);
    if (file == files->end()) continue;
    const auto kept = KeptJournals(scene_id);
    if (!kept.ok()) continue;
    const auto journals = FoundJournals::Read(*directory_, *kept, options_.database);
    restored.push_back(RestoreScene(scene_id, file->second, journals, blobs, limits));
    if (!restored.back().status.ok()) continue;
    std::lock_guard lock(mutex_);
    kept_journals_.erase(scene_id);
  }
  Tell(restored, /*again=*/true);
  return restored;
}

void SceneStorage::Tell(const std::vector<RestoredScene>& restored, bool again) {
  for (const RestoredScene& scene : restored) {
    const std::string error(scene.status.message());
    if (scene.status.ok()) {
      Note(*scene.log, scene.scene->revision());
    } else if (scene.is_for_now()) {
      if (again) continue;  // it has been told
      logger_.Warning("scene_unavailable", {{"scene", scene.scene_id}, {"error", error}});
    } else {
      // It is left as it is.
      logger_.Error("scene_refused", {{"scene", scene.scene_id}, {"error", error}});
    }
  }
}

// All that the server has found, where nobody knows which the scene needs.
absl::StatusOr<std::vector<uint64_t>> SceneStorage::KeptJournals(const std::string& scene_id) {
  {
    std::lock_guard lock(mutex_);
    const auto kept = kept_journals_.find(scene_id);
    if (kept != kept_journals_.end()) return kept->second;
    if (are_journals_known_) return std::vector<uint64_t>();
  }
  auto numbers = directory_->Journals();
  if (numbers.ok()) {
    std::erase_if(*numbers, [this](uint64_t number) { return journals_.HasGiven(number); });
  }
  return numbers;
}

FoundJournals SceneStorage::ReadJournals() {
  const auto numbers = directory_->Journals();
  if (numbers.ok()) return FoundJournals::Read(*directory_, *numbers, options_.database);
  logger_.Error("journals_unreadable", {{"error", std::string(numbers.status().message())}});
  return FoundJournals::Unknown(numbers.status());
}

// What was in journals is in the scenes' own files now, but for scenes that are refused.
void SceneStorage::RemoveJournals(const FoundJournals& journals,
                                  const std::vector<RestoredScene>& restored) {
  std::set<uint64_t> needed;
  for (const RestoredScene& scene : restored) {
    if (scene.status.ok()) continue;
    auto by_scene = journals.NeededBy(scene.need);
    needed.insert(by_scene.begin(), by_scene.end());
    std::lock_guard lock(mutex_);
    kept_journals_[scene.scene_id] = std::move(by_scene);
  }
  uint64_t kept_bytes = 0;
  for (const FoundJournals::Journal& journal : journals.all()) {
    const std::string error(journal.status.message());
    if (needed.contains(journal.number)) {
      kept_bytes += journal.bytes;
      if (absl::IsDataLoss(journal.status)) {
        logger_.Error("journal_damaged", {{"journal", journal.number}, {"error", error}});
      }
      continue;
    }
    // A crash while a journal ends may leave it without its log, or with one that is cleared.
    if (!error.empty()) {
      logger_.Info("unused_journal_removed", {{"journal", journal.number}, {"error", error}});
    }
    directory_->RemoveJournal(journal.number).IgnoreError();
  }
  if (!needed.empty()) {
    logger_.Warning("journals_kept", {{"journals", needed.size()}, {"bytes", kept_bytes}});
  }
  std::lock_guard lock(mutex_);
  are_journals_known_ = true;
}

RestoredScene SceneStorage::RestoreScene(const std::string& scene_id, uint64_t number,
                                         const FoundJournals& journals, BlobStore& blobs,
                                         const SceneLimits& limits) {
  const std::string path = directory_->ScenePath(scene_id, number);
  auto file = OpenFound(path, options_.database);
  RestoredScene restored{.scene_id = scene_id,
                         .need = NeedOf(scene_id, path, file.ok() ? file->get() : nullptr)};
  const auto refuse = [&](absl::Status status) {
    restored.status = std::move(status);
    return std::move(restored);
  };
  if (!file.ok()) return refuse(file.status());
  if ((*file)->identity().scene_id != scene_id) return refuse(Damaged("another scene's file"));
  auto newer = journals.NewerThan(**file);
  if (!newer.ok()) return refuse(newer.status());
  const Revision newest = newer->empty() ? (*file)->head().revision : newer->back().revision;
  if (auto status = CheckAgainstHeads((*file)->identity(), newest); !status.ok()) {
    restored.need = {};  // the scene's own file may be elsewhere, and name any journal
    return refuse(status);
  }
  if ((*file)->had_torn_tail()) {
    // As after a loss of power. What was in it was not acknowledged, or the heads would know.
    logger_.Warning("torn_transaction_dropped", {{"scene", scene_id}, {"revision", newest}});
  }
  auto state = (*file)->StateAt((*file)->head().revision);
  if (!state.ok()) return refuse(state.status());
  state->commits.insert(state->commits.end(), newer->begin(), newer->end());
  const LoadedBlobs loaded(blobs);
  auto scene = SceneOf(scene_id, *state, loaded, limits);
  if (!scene.ok()) return refuse(loaded.failed().ok() ? scene.status() : loaded.failed());
  if (auto status = MakeLast(**file, *newer); !status.ok()) return refuse(status);
  auto answers = (*file)->Answers(options_.history);
  if (!answers.ok()) return refuse(answers.status());
  // Older ones are what is left of a time when writing failed.
  directory_->RemoveScene(scene_id, number).IgnoreError();
  restored.scene = *std::move(scene);
  restored.answers = *std::move(answers);
  restored.log = Log(*std::move(file));
  return restored;
}

// `file`  null: what is at `path` cannot be opened
JournalNeed SceneStorage::NeedOf(const std::string& scene_id, const std::string& path,
                                 const SceneFile* file) {
  JournalNeed need;
  if (const auto known = Known(scene_id)) need.incarnation = known->incarnation;
  if (file) {
    const std::string& incarnation = file->identity().incarnation;
    // What an earlier scene's file tells says nothing of this one.
    if (!need.incarnation.empty() && need.incarnation != incarnation) return {};
    return {.named = file->journal(), .incarnation = incarnation, .head = file->head().revision};
  }
  auto named = SceneFile::NamedJournal(path, options_.database);
  if (named.ok()) need.named = *std::move(named);
  // What cannot be read now may be sound, and name any journal.
  if (!named.ok() && !absl::IsDataLoss(named.status())) need.incarnation.clear();
  return need;
}

// What has been read may be in the system's memory only; from here on others build on it. After an
// error it is all there to be read again, and then written again.
absl::Status SceneStorage::MakeLast(SceneFile& file, const std::vector<CommitRecord>& newer) {
  absl::Status status = file.Settle();
  if (status.ok() && !file.journal().empty()) status = file.Append(newer);
  if (!status.ok()) file.Abandon();
  return status;
}

std::optional<KnownHead> SceneStorage::Known(const std::string& scene_id) {
  std::lock_guard lock(mutex_);
  const auto known = heads_.find(scene_id);
  return known == heads_.end() ? std::nullopt : std::optional(known->second);
}

absl::Status SceneStorage::CheckAgainstHeads(const SceneIdentity& identity, Revision revision) {
  if (identity.owner != directory_->identity()) {
    return FieldError(absl::StatusCode::kFailedPrecondition, "FOREIGN", "scene",
                      "found the file of another server, need one that was imported");
  }
  const auto known = Known(identity.scene_id);
  if (!known) return absl::OkStatus();
  if (known->incarnation != identity.incarnation) {
    return Damaged("the file of an earlier scene of this id");
  }
  if (known->revision > revision) {
    return Damaged(
        absl::StrCat("revision ", revision, ", where ", known->revision, " was on disk"));
  }
  return absl::OkStatus();
}

}  // namespace penumbra
