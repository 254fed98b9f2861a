// What becomes of scenes that came as archives which no server of ours wrote.
#include <gtest/gtest.h>

#include <filesystem>

#include "render/scene/field_error.h"
#include "tests/integration/service/import_call.h"
#include "tests/support/faulty_vfs.h"

namespace penumbra::testing {
namespace {

using ImportedScenesTest = ImportTest;

TEST_F(ImportedScenesTest, AKeyThatComesTwiceStandsForTheNewerCommit) {
  FaultyVfs disk;
  options_.storage.database.vfs = disk.name();
  options_.limits.max_idempotency_keys = 3;
  SetUp();
  Records records = SmallImport();
  records[4].mutable_commit()->set_idempotency_key("key-2");  // as records[3]
  TieAnew(records);
  ASSERT_EQ(Import(records), absl::OkStatus());
  session_ = client_->OpenSession("studio");
  ASSERT_EQ(session_->Commit(MoveBox({1, 1, 0}), "first").revision(), 4u);
  ASSERT_EQ(session_->Commit(MoveBox({2, 1, 0}), "second").revision(), 5u);
  EXPECT_EQ(ErrorReason(ErrorIn(session_->Commit(MoveBox({0, 1, 0}), "key-2"))),
            "REQUEST_ID_REUSED")
      << "it is one of three that are remembered";
  // All that is remembered is written into a new file.
  disk.FailAfter(0, FaultyVfs::Call::kSync, SQLITE_IOERR_FSYNC);
  EXPECT_EQ(ErrorIn(session_->Commit(MoveBox({3, 1, 0}), "third")).code(),
            absl::StatusCode::kUnavailable);
  disk.Heal();
  EXPECT_EQ(session_->Commit(MoveBox({3, 1, 0}), "third").revision(), 6u);
  options_.storage.database.vfs = nullptr;
  Restart();
  session_ = client_->OpenSession("studio");
  EXPECT_EQ(session_->Commit(MoveBox({1, 1, 0}), "first").revision(), 4u);
  EXPECT_EQ(client_->FindScene("studio")->revision, 6u);
}

TEST_F(ImportedScenesTest, AHistoryThatWouldFillTheDiskIsRefusedWhereItBeginsTo) {
  options_.limits.max_history_bytes = 300;  // and so of one commit
  SetUp();
  const absl::Status status = Import(SmallImport());
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted) << status;
  EXPECT_EQ(ErrorReason(status), "QUOTA_HISTORY_BYTES");
  EXPECT_EQ(ErrorFieldPath(status), "records[3]");
  EXPECT_NE(status.message().find("need at most 600"), absl::string_view::npos) << status;
  EXPECT_TRUE(client_->ListScenes()->empty());
  EXPECT_TRUE(std::filesystem::is_empty(folder_ / "data/scenes"));
}

}  // namespace
}  // namespace penumbra::testing
