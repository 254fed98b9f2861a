// What a storage finds when a server starts: scenes' files, and journals with their newest commits.

#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"
#include "server/scene_store/scene_storage.h"
#include "server/scene_store/stored_scene.h"
#include "server/storage/scene_rows.h"

namespace penumbra {
namespace {

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
    restored.push_back({.scene_id = scene_id,
                        .status = Damaged(absl::StrCat("no file, where revision ", known.revision,
                                                       " was on disk")),
                        .need = {.named = std::string(), .incarnation = known.incarnation}});
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
  if (files.ok()) RemoveJournals(journals, restored);
  return restored;
}

FoundJournals SceneStorage::ReadJournals() {
  const auto numbers = directory_->Journals();
  if (numbers.ok()) return FoundJournals::Read(*directory_, *numbers, options_.database);
  logger_.Error("journals_unreadable", {{"error", std::string(numbers.status().message())}});
  return {};
}

// What was in journals is in the scenes' own files now, but for scenes that are refused.
void SceneStorage::RemoveJournals(const FoundJournals& journals,
                                  const std::vector<RestoredScene>& restored) {
  std::set<uint64_t> needed;
  for (const RestoredScene& scene : restored) {
    if (scene.status.ok()) continue;
    const auto by_scene = journals.NeededBy(scene.need);
    needed.insert(by_scene.begin(), by_scene.end());
  }
  for (const FoundJournals::Journal& journal : journals.all()) {
    const std::string error(journal.status.message());
    if (needed.contains(journal.number)) {
      if (!error.empty()) {
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
}

RestoredScene SceneStorage::RestoreScene(const std::string& scene_id, uint64_t number,
                                         const FoundJournals& journals, BlobStore& blobs,
                                         const SceneLimits& limits) {
  const std::string path = directory_->ScenePath(scene_id, number);
  auto file = SceneFile::Open(path, options_.database);
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
    return refuse(status);
  }
  if ((*file)->had_torn_tail()) {
    // As after a loss of power. What was in it was not acknowledged, or the heads would know.
    logger_.Warning("torn_transaction_dropped", {{"scene", scene_id}, {"revision", newest}});
  }
  auto state = (*file)->StateAt((*file)->head().revision);
  if (!state.ok()) return refuse(state.status());
  state->commits.insert(state->commits.end(), newer->begin(), newer->end());
  auto scene = SceneOf(scene_id, *state, LoadedBlobs(blobs), limits);
  if (!scene.ok()) return refuse(scene.status());
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
                                 const SceneFile* file) const {
  JournalNeed need;
  if (const auto known = heads_.find(scene_id); known != heads_.end()) {
    need.incarnation = known->second.incarnation;
  }
  if (file) {
    need.named = file->journal();
    need.head = file->head().revision;
    return need;
  }
  auto named = SceneFile::NamedJournal(path, options_.database);
  if (named.ok()) need.named = *std::move(named);
  // What cannot be read now may be sound, and name any journal.
  if (!named.ok() && !absl::IsDataLoss(named.status())) need.incarnation.clear();
  return need;
}

// What has been read may be in the system's memory only; from here on others build on it.
absl::Status SceneStorage::MakeLast(SceneFile& file, const std::vector<CommitRecord>& newer) {
  if (auto status = file.Settle(); !status.ok()) return status;
  return file.journal().empty() ? absl::OkStatus() : file.Append(newer);
}

absl::Status SceneStorage::CheckAgainstHeads(const SceneIdentity& identity,
                                             Revision revision) const {
  if (identity.owner != directory_->identity()) {
    return FieldError(absl::StatusCode::kFailedPrecondition, "FOREIGN", "scene",
                      "found the file of another server, need one that was imported");
  }
  const auto known = heads_.find(identity.scene_id);
  if (known == heads_.end()) return absl::OkStatus();
  if (known->second.incarnation != identity.incarnation) {
    return Damaged("the file of an earlier scene of this id");
  }
  if (known->second.revision > revision) {
    return Damaged(
        absl::StrCat("revision ", revision, ", where ", known->second.revision, " was on disk"));
  }
  return absl::OkStatus();
}

}  // namespace penumbra
