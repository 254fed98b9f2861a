#include "tests/unit/server/logged_scenes.h"

#include <gtest/gtest.h>

#include <optional>
#include <span>

#include "proto/convert/scene_convert.h"
#include "server/scene_store/scene_storage.h"
#include "server/scene_store/stored_scene.h"

namespace penumbra::testing {
namespace {

constexpr int kManyAppends = 100;

SceneDelta LampAt(Revision revision) {
  SceneDelta delta;
  const auto height = static_cast<float>(revision);
  delta.upsert_lights = {{.id = "lamp", .shape = PointLight{.position = {0, height, 0}}}};
  return delta;
}

std::shared_ptr<const Scene> After(const Scene& scene) {
  return scene.Apply(LampAt(scene.revision() + 1)).value();
}

CommitRecord RecordOf(const Scene& after) {
  return {.revision = after.revision(),
          .content_hash = after.content_hash(),
          .author = "tester",
          .delta = ToProto(LampAt(after.revision())).SerializeAsString()};
}

}  // namespace

std::shared_ptr<const Scene> LampScene(const std::string& scene_id, Revision revision) {
  auto scene = Scene::Empty(scene_id);
  while (scene->revision() < revision) scene = After(*scene);
  return scene;
}

void LoggedScenes::Make(const std::string& folder, const std::vector<std::string>& ids) {
  const auto directory = DataDirectory::Open(folder).value();
  for (const std::string& id : ids) {
    // Sixteen bytes of its own.
    const std::string incarnation = (id + std::string(16, '.')).substr(0, 16);
    const auto file =
        SceneFile::Create(
            directory->ScenePath(id, 1),
            {.scene_id = id, .incarnation = incarnation, .owner = directory->identity()}, {})
            .value();
    ASSERT_EQ(file->Settle(), absl::OkStatus());
  }
}

LoggedScenes::LoggedScenes(const std::string& folder, SceneLogOptions options)
    : directory_(DataDirectory::Open(folder).value()),
      options_(std::move(options)),
      journals_(*directory_, options_.database, QuietLogger()) {}

absl::Status LoggedScenes::Open() {
  const auto files = directory_->SceneFiles();
  if (!files.ok()) return files.status();
  for (const auto& [id, number] : *files) {
    auto file = SceneFile::Open(directory_->ScenePath(id, number), options_.database);
    if (!file.ok()) return file.status();
    if (auto status = (*file)->Settle(); !status.ok()) return status;
    auto newest = LampScene(id, (*file)->head().revision);
    scenes_[id] = {
        .log = std::make_unique<SceneLog>(*directory_, journals_, options_, *std::move(file)),
        .newest = std::move(newest)};
  }
  return absl::OkStatus();
}

absl::Status LoggedScenes::MakeBusy(const std::string& id) {
  for (int i = 0; i < kManyAppends && !log(id).is_in_journal(); ++i) {
    if (auto status = CommitToFile(id); !status.ok()) return status;
  }
  return log(id).is_in_journal() ? absl::OkStatus() : absl::DeadlineExceededError("too slow");
}

absl::Status LoggedScenes::CommitToFile(const std::string& id) {
  LoggedScene& scene = scenes_.at(id);
  const auto after = After(*scene.newest);
  const CommitRecord commit = RecordOf(*after);
  const absl::Status status = scene.log->Append(
      {&commit, 1}, [&] { return SceneState{.snapshot = SnapshotOf(*scene.newest)}; });
  if (status.ok()) scene.newest = after;
  return status;
}

LoggedScenes::Written LoggedScenes::CommitTogether(const std::vector<std::string>& ids, int count) {
  Written written;
  std::map<std::shared_ptr<JournalInUse>, std::vector<Part>> parts;
  for (const std::string& id : ids) {
    Part part{.scene = &scenes_.at(id), .after = scenes_.at(id).newest, .entries = {}};
    std::vector<CommitRecord> commits;
    for (int i = 0; i < count; ++i) {
      part.after = After(*part.after);
      commits.push_back(RecordOf(*part.after));
    }
    if (auto entered = part.scene->log->EnterJournal(std::move(commits))) {
      part.entries = std::move(entered->entries);
      parts[entered->journal].push_back(std::move(part));
    } else if (auto status = CommitToFile(id); !status.ok()) {
      written.status = status;
    }
  }
  for (auto& [journal, of_journal] : parts) {
    JournalEntries all;
    for (const Part& part : of_journal) all.push_back(part.entries);
    const absl::Status status = journals_.Append(*journal, all);
    for (Part& part : of_journal) {
      part.scene->log->LeaveJournal(std::move(part.entries), status.ok());
      if (status.ok()) part.scene->newest = part.after;
    }
    if (status.ok()) written.journals.insert(journal->id());
    if (!status.ok()) written.status = status;
  }
  return written;
}

std::map<std::string, Revision> LoggedScenes::acknowledged() const {
  std::map<std::string, Revision> revisions;
  for (const auto& [id, scene] : scenes_) revisions[id] = scene.newest->revision();
  return revisions;
}

void ExpectRestored(const std::string& folder, const SceneLogOptions& options,
                    const std::map<std::string, Revision>& acknowledged, Revision later,
                    const std::string& what) {
  const ServerLimits limits;
  BlobStore blobs(limits);
  const auto storage = SceneStorage::Open(folder, options, QuietLogger()).value();
  const auto restored = storage->Restore(blobs, limits.scene);
  EXPECT_EQ(restored.size(), acknowledged.size()) << what;
  for (const RestoredScene& one : restored) {
    ASSERT_EQ(one.status, absl::OkStatus()) << what << ": " << one.scene_id;
    const Revision found = one.scene->revision(), least = acknowledged.at(one.scene_id);
    EXPECT_GE(found, least) << what << ": " << one.scene_id;
    EXPECT_LE(found, least + later) << what << ": " << one.scene_id;
    EXPECT_EQ(one.scene->content_hash(), LampScene(one.scene_id, found)->content_hash()) << what;
  }
  storage->Stop();
}

}  // namespace penumbra::testing
