// A server with scenes that are edited so fast that their commits go to a journal.
//
// Whether they do is up to the server, and to how fast the machine is: tests ask what a kill
// leaves, and go on until that is what they are about.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>

#include "server/storage/commit_journal.h"
#include "tests/integration/service/durable_scenes.h"
#include "tests/support/left_by_kill.h"

namespace penumbra::testing {

class BusyScenesTest : public DurableScenesTest {
 protected:
  // So many commits in a journal are many.
  static constexpr Revision kMany = 10;

  // A scene that is edited now and then, and one that somebody drags things in.
  void SetUp() override {
    Restart();
    MakeStudio("quiet");
    MakeStudio("busy");
    DragUntilBusy();
  }
  void Restart() {
    other_.reset();
    DurableScenesTest::Restart();
  }
  // Another that is dragged in from now on.
  void MakeOther() {
    ASSERT_EQ(client_->CreateScene("other"), absl::OkStatus());
    other_ = client_->OpenSession("other");
    ASSERT_EQ(other_->Commit(StudioDelta()).revision(), 1u);
  }

  static SceneDelta Place(int drag) { return MoveBox({0, 1, 0.01f * static_cast<float>(drag)}); }
  static std::string KeyOf(int drag) { return "drag" + std::to_string(drag); }
  void Drag() {
    ++drags_;
    for (WireSession* session : {session_.get(), other_.get()}) {
      if (!session) continue;
      const auto result = session->Commit(Place(drags_), KeyOf(drags_));
      ASSERT_FALSE(result.has_error()) << ErrorIn(result);
    }
  }
  // Until a kill at this moment leaves many commits of each scene that is dragged in in a journal.
  void DragUntilBusy() {
    const auto end = std::chrono::steady_clock::now() + kPatience;
    do {
      ASSERT_LT(std::chrono::steady_clock::now(), end) << "the scene does not get busy";
      for (Revision i = 0; i < kMany; ++i) ASSERT_NO_FATAL_FAILURE(Drag());
      Copy();
    } while ((session_ && JournalledInCopy("busy") < kMany) ||
             (other_ && JournalledInCopy("other") < kMany));
    before_ = client_->FindScene("busy").value_or(SceneInfo());
  }

  // The folder as it is at this moment, as a kill leaves it.
  void Copy() { LeaveAsByKill(folder_ / "data", folder_ / "copy"); }
  // Its commits that are in a journal there and nowhere else. All of them are acknowledged.
  Revision JournalledInCopy(const std::string& id) {
    const auto file = SceneFileIn(folder_ / "copy", id);
    if (!file || file->journal().empty()) return 0;
    return client_->FindScene(id)->revision - file->head().revision;
  }
  // Of how many scenes the journal there has commits.
  size_t ScenesInCopiedJournal() {
    const auto journal = ReadJournal(folder_ / "copy/journals/1.db", {});
    return journal.ok() ? journal->commits.size() : 0;
  }
  // The server is gone, and the folder as it was when it was copied.
  void BecomeCopy() {
    session_.reset();
    other_.reset();
    client_.reset();
    server_.reset();
    std::filesystem::remove_all(folder_ / "data");
    std::filesystem::rename(folder_ / "copy", folder_ / "data");
  }
  void Crash() {
    Copy();
    BecomeCopy();
  }
  void CrashWhileBusy() {
    ASSERT_NO_FATAL_FAILURE(DragUntilBusy());
    BecomeCopy();
  }

  std::string Journal() { return folder_ / "data/journals/1.db"; }
  void ExpectAsBefore() {
    const SceneInfo after = client_->FindScene("busy").value();
    EXPECT_EQ(after.revision, before_.revision);
    EXPECT_EQ(after.content_hash, before_.content_hash);
    EXPECT_EQ(client_->FindScene("quiet")->revision, 1u);
  }
  void ExpectRefused() {
    EXPECT_EQ(logger_.Await("scene_refused", 1)[0]["scene"], "busy");
    EXPECT_EQ(EndOfSession("busy").code(), absl::StatusCode::kDataLoss);
    EXPECT_EQ(client_->FindScene("quiet")->revision, 1u) << "nothing of it is in the journal";
  }

  SceneInfo before_;  // "busy" when it was copied last
  std::unique_ptr<WireSession> other_;
  int drags_ = 0;
};

}  // namespace penumbra::testing
