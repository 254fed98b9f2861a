// Scenes out of one server and into another as archives.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <thread>

#include "client/session/scene_archive.h"
#include "render/scene/field_error.h"
#include "tests/integration/session/remote_engine_fixture.h"
#include "tests/support/temporary_folder.h"

namespace penumbra::testing {
namespace {

namespace fs = std::filesystem;

// A server, with a folder for its scenes or without, and a client.
struct Site {
  ServerOptions options{.listen = "127.0.0.1:0", .opens_gl = false};
  std::unique_ptr<PenumbraServer> server;
  std::unique_ptr<RemoteEngine> engine;

  void Start() {
    engine.reset();
    server.reset();
    server = PenumbraServer::Start(options).value();
    engine = RemoteEngine::Connect({.address = server->address()}).value();
  }
  SceneInfo Find(const std::string& id) {
    const auto scenes = engine->ListScenes();
    for (const SceneInfo& info : scenes.value()) {
      if (info.id == id) return info;
    }
    return {};
  }
};

class ArchivesTest : public ::testing::Test {
 protected:
  void SetUp() override { Begin({.commits = 1'000}); }
  void Begin(const HistoryLimits& history) {
    from_.options.storage.history = history;
    from_.options.data_dir = folder_ / "from";
    from_.Start();
  }
  // `count` commits; the first makes the studio.
  static void Edit(Site& site, int count, const std::string& id = "studio") {
    for (int i = 0; i < count; ++i) {
      const float x = 0.01f * static_cast<float>(i);
      ASSERT_TRUE(site.engine->Commit(id, Studio(Vec3(x, 0.5f, 0))).ok());
    }
  }
  void MakeStudio(int commits) {
    ASSERT_EQ(from_.engine->CreateScene("studio"), absl::OkStatus());
    Edit(from_, commits);
  }
  static std::vector<uint16_t> Counts(Site& site, const std::string& id) {
    const auto artifact = ComputeOnce(*site.engine, id, FloorSpec());
    EXPECT_TRUE(artifact.ok()) << artifact.status();
    return artifact.ok() ? CountsOf(**artifact) : std::vector<uint16_t>();
  }

  const TemporaryFolder folder_;
  const std::string file_ = folder_ / "studio.penumbra";
  Site from_;
  Site to_;
};

// A server of another build, which takes few blobs at a time and short messages.
TEST_F(ArchivesTest, BlobsGoInAsManyCallsAsTheServerWants) {
  ASSERT_EQ(from_.engine->CreateScene("studio"), absl::OkStatus());
  SceneDelta delta = Studio();
  for (int i = 0; i < 11; ++i) {
    // The last one takes several messages.
    MeshGeometry geometry = UnitBoxGeometry();
    const size_t copies = i < 10 ? 1 : 200;
    for (size_t k = 0; k < copies; ++k) {
      const auto first = static_cast<uint32_t>(geometry.positions.size());
      for (const float x : {0.0f, 1.0f})
        geometry.positions.push_back({x, 2.0f + 0.1f * i, 0.01f * k});
      geometry.indices.insert(geometry.indices.end(), {0, first, first + 1});
    }
    delta.upsert_instances.push_back({.id = "thing" + std::to_string(i), .mesh = MeshOf(geometry)});
  }
  ASSERT_TRUE(from_.engine->Commit("studio", delta).ok());
  ASSERT_EQ(from_.engine->ExportScene("studio", file_), absl::OkStatus());
  to_.options.limits.max_hashes_per_request = 4;
  to_.options.limits.max_message_bytes = 4 << 10;
  to_.Start();
  const auto imported = to_.engine->ImportScene(file_);
  ASSERT_EQ(imported.status(), absl::OkStatus());
  EXPECT_EQ(imported->content_hash, from_.Find("studio").content_hash);
}

TEST_F(ArchivesTest, WhatIsExportedDeletedAndImportedIsTheSame) {
  MakeStudio(6);
  const SceneInfo before = from_.Find("studio");
  const auto counts = Counts(from_, "studio");
  ASSERT_EQ(from_.engine->ExportScene("studio", file_), absl::OkStatus());
  ASSERT_EQ(from_.engine->DeleteScene("studio"), absl::OkStatus());
  const auto imported = from_.engine->ImportScene(file_);
  ASSERT_EQ(imported.status(), absl::OkStatus());
  EXPECT_EQ(imported->revision, 6u);
  EXPECT_EQ(imported->content_hash, before.content_hash);
  EXPECT_EQ(Counts(from_, "studio"), counts) << "bit for bit";
  // On disk too, and ready for more.
  from_.Start();
  EXPECT_EQ(from_.Find("studio").content_hash, before.content_hash);
  EXPECT_EQ(from_.engine->Commit("studio", Studio()).value(), 7u);
  // The archive of it has the whole history again.
  ASSERT_EQ(from_.engine->ExportScene("studio", file_), absl::OkStatus());
  const auto again = ReadArchive(file_);
  ASSERT_EQ(again.status(), absl::OkStatus());
  EXPECT_EQ(again->base_revision, 0u);
  EXPECT_EQ(again->revision, 7u);
}

TEST_F(ArchivesTest, IntoAnotherServerWithAndWithoutAFolder) {
  MakeStudio(4);
  ASSERT_EQ(from_.engine->ExportScene("studio", file_), absl::OkStatus());
  for (const std::string& folder : {std::string(), folder_ / "to"}) {
    to_.options.data_dir = folder;
    to_.Start();
    const auto imported = to_.engine->ImportScene(file_, "copy");
    ASSERT_EQ(imported.status(), absl::OkStatus());
    EXPECT_EQ(imported->id, "copy");
    EXPECT_EQ(imported->content_hash, from_.Find("studio").content_hash);
    EXPECT_EQ(Counts(to_, "copy"), Counts(from_, "studio"));
    EXPECT_EQ(to_.engine->Commit("copy", Studio()).value(), 5u);
    // And on from there: one that lives in memory has no history to tell.
    const std::string back = folder_ / "back.penumbra";
    ASSERT_EQ(to_.engine->ExportScene("copy", back), absl::OkStatus());
    const auto info = ReadArchive(back);
    ASSERT_EQ(info.status(), absl::OkStatus());
    EXPECT_EQ(info->base_revision, folder.empty() ? 5u : 0u);
    EXPECT_EQ(info->scene->content_hash(), to_.Find("copy").content_hash);
  }
}

TEST_F(ArchivesTest, OfACompactedSceneThereIsABaseAndWhatCameAfter) {
  Begin({.commits = 10, .snapshot_after_bytes = 1u << 20});
  MakeStudio(47);
  ASSERT_EQ(from_.engine->ExportScene("studio", file_), absl::OkStatus());
  int commits = 0;
  const auto info = ReadArchive(file_, {.on_change = [&](const ArchivedChange&) {
                                  ++commits;
                                  return absl::OkStatus();
                                }});
  ASSERT_EQ(info.status(), absl::OkStatus());
  EXPECT_GE(info->base_revision, 20u);
  EXPECT_EQ(info->revision, 47u);
  EXPECT_EQ(commits, static_cast<int>(47 - info->base_revision));
  EXPECT_GE(commits, 10);
  to_.options.data_dir = folder_ / "to";
  to_.Start();
  ASSERT_EQ(to_.engine->ImportScene(file_).status(), absl::OkStatus());
  to_.Start();
  EXPECT_EQ(to_.Find("studio").content_hash, from_.Find("studio").content_hash);
  EXPECT_EQ(to_.Find("studio").revision, 47u);
  // Without its history it is the scene alone.
  ASSERT_EQ(from_.engine->ExportScene("studio", file_, {.with_history = false}), absl::OkStatus());
  EXPECT_EQ(ReadArchive(file_)->base_revision, 47u);
}

TEST_F(ArchivesTest, AnEmptySceneHasAnArchiveToo) {
  ASSERT_EQ(from_.engine->CreateScene("void"), absl::OkStatus());
  ASSERT_EQ(from_.engine->ExportScene("void", file_), absl::OkStatus());
  const auto imported = from_.engine->ImportScene(file_, "void-2");
  ASSERT_EQ(imported.status(), absl::OkStatus());
  EXPECT_EQ(imported->revision, 0u);
  from_.Start();
  EXPECT_EQ(from_.engine->Commit("void-2", Studio()).value(), 1u);
}

// Edits go on, and each archive is of one revision.
TEST_F(ArchivesTest, ASceneIsExportedWhileItIsEdited) {
  Begin({.commits = 50, .snapshot_after_bytes = 1u << 20});
  MakeStudio(10);
  std::atomic<bool> is_over = false;
  std::atomic<int> edits = 0;
  std::thread editor([&] {
    const auto engine = RemoteEngine::Connect({.address = from_.server->address()}).value();
    for (int i = 0; !is_over; ++i) {
      EXPECT_TRUE(engine->Commit("studio", Studio(Vec3(0.001f * (i % 500), 0.5f, 0))).ok());
      ++edits;
    }
  });
  Revision last = 0;
  for (int i = 0; i < 15; ++i) {
    const int before = edits;
    ASSERT_EQ(from_.engine->ExportScene("studio", file_), absl::OkStatus());
    const auto info = ReadArchive(file_);
    ASSERT_EQ(info.status(), absl::OkStatus());
    EXPECT_GE(info->revision, last);
    last = info->revision;
    for (int j = 0; j < 500 && edits < before + 20; ++j) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    EXPECT_GT(edits, before) << "an export stops no edits";
  }
  is_over = true;
  editor.join();
  EXPECT_GT(ReadArchive(file_)->base_revision, 0u) << "history is compacted in between";
}

TEST_F(ArchivesTest, BlobsThatOnlyTheHistoryNamesAreInIt) {
  from_.options.limits.unused_blob_lifetime = std::chrono::seconds(0);
  from_.options.storage.house_interval = std::chrono::seconds(1);
  from_.Start();
  ASSERT_EQ(from_.engine->CreateScene("studio"), absl::OkStatus());
  SceneDelta square = Studio();
  square.upsert_instances[0].mesh = MeshOf(UnitSquareGeometry());
  ASSERT_TRUE(from_.engine->Commit("studio", square).ok());
  ASSERT_TRUE(from_.engine->Commit("studio", Studio()).ok());
  from_.Start();
  std::this_thread::sleep_for(std::chrono::milliseconds(2'200));  // until the house is kept
  ASSERT_EQ(from_.engine->ExportScene("studio", file_), absl::OkStatus());
  const auto info = ReadArchive(file_);
  ASSERT_EQ(info.status(), absl::OkStatus());
  EXPECT_EQ(info->blobs.size(), 2u);
  to_.options.data_dir = folder_ / "to";
  to_.Start();
  ASSERT_EQ(to_.engine->ImportScene(file_).status(), absl::OkStatus());
  const std::string back = folder_ / "back.penumbra";
  ASSERT_EQ(to_.engine->ExportScene("studio", back), absl::OkStatus());
  EXPECT_EQ(ReadArchive(back)->blobs.size(), 2u);
}

TEST_F(ArchivesTest, AnIdInUseIsRefusedAndAnotherIsTaken) {
  MakeStudio(2);
  ASSERT_EQ(from_.engine->ExportScene("studio", file_), absl::OkStatus());
  Edit(from_, 1);
  const SceneInfo before = from_.Find("studio");
  const auto refused = from_.engine->ImportScene(file_);
  EXPECT_EQ(refused.status().code(), absl::StatusCode::kAlreadyExists);
  EXPECT_EQ(ErrorReason(refused.status()), "DUPLICATE_ID");
  EXPECT_EQ(from_.Find("studio").content_hash, before.content_hash);
  EXPECT_EQ(from_.Find("studio").revision, 3u);
  EXPECT_EQ(from_.engine->ImportScene(file_, "studio-2").status(), absl::OkStatus());
  EXPECT_EQ(from_.engine->ExportScene("none", file_).code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(ReadArchive(file_).status(), absl::OkStatus()) << "a failed export leaves the file";
}

TEST_F(ArchivesTest, ADamagedArchiveMakesNothing) {
  MakeStudio(5);
  ASSERT_EQ(from_.engine->ExportScene("studio", file_), absl::OkStatus());
  ASSERT_EQ(from_.engine->DeleteScene("studio"), absl::OkStatus());
  std::ifstream whole(file_, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(whole)), {});
  for (size_t at = 100; at < bytes.size(); at += bytes.size() / 20) {
    std::string flipped = bytes;
    flipped[at] = static_cast<char>(flipped[at] ^ 16);
    std::ofstream(file_, std::ios::binary) << flipped;
    EXPECT_EQ(ErrorReason(from_.engine->ImportScene(file_).status()), "DAMAGED") << at;
    std::ofstream(file_, std::ios::binary) << bytes.substr(0, at);
    EXPECT_EQ(ErrorReason(from_.engine->ImportScene(file_).status()), "DAMAGED") << at;
  }
  EXPECT_TRUE(from_.engine->ListScenes()->empty());
  EXPECT_TRUE(fs::is_empty(folder_ / "from/scenes"));
}

TEST_F(ArchivesTest, AStopEndsAnExportAndLeavesNoFile) {
  MakeStudio(2);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_FALSE(from_.engine->ExportScene("studio", file_, {.stop = stop.get_token()}).ok());
  EXPECT_FALSE(fs::exists(file_));
}

}  // namespace
}  // namespace penumbra::testing
