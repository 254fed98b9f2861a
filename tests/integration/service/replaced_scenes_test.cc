// Scenes that are exported, deleted and made anew while a journal has their commits.

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "proto/archive/archive_order.h"
#include "proto/convert/status_convert.h"
#include "render/scene/field_error.h"
#include "tests/integration/service/busy_scenes.h"
#include "tests/integration/service/import_call.h"

namespace penumbra::testing {
namespace {

// As an import takes them: blobs are uploaded before.
Records WithoutBytesOfBlobs(const Records& archive) {
  Records records;
  bool is_blob = false;
  for (const v1::ArchiveRecord& record : archive) {
    const bool goes_on = !record.has_head() && !record.has_blob() && !record.has_base() &&
                         !record.has_commit() && !record.has_end();
    if (goes_on && is_blob) continue;
    if (!goes_on) is_blob = record.has_blob();
    records.push_back(record);
    if (is_blob) records.back().clear_data();
  }
  return records;
}

class ReplacedScenesTest : public BusyScenesTest {
 protected:
  // Another scene has commits in the journal as well, which stays for that one.
  void SetUp() override {
    BusyScenesTest::SetUp();
    MakeOther();
    DragUntilBusy();
    ASSERT_EQ(ScenesInCopiedJournal(), 2u);
  }
  Records Export(const std::string& id) {
    v1::ExportSceneRequest request;
    request.set_scene_id(id);
    grpc::ClientContext context;
    const auto reader = client_->stub().ExportScene(&context, request);
    Records records;
    v1::ExportSceneResponse response;
    while (reader->Read(&response)) {
      records.insert(records.end(), response.records().begin(), response.records().end());
    }
    EXPECT_EQ(FromGrpcStatus(reader->Finish()), absl::OkStatus());
    return records;
  }
  void Delete() {
    ASSERT_EQ(client_->DeleteScene("busy"), absl::OkStatus());
    EXPECT_EQ(session_->End().code(), absl::StatusCode::kNotFound);
    session_.reset();
  }
  // A kill, with commits in the journal of the scene of that id that there is, of one that there
  // was, and of the other.
  void CrashWithBoth() {
    DragUntilBusy();
    other_before_ = client_->FindScene("other").value();
    EXPECT_EQ(ScenesInCopiedJournal(), 3u) << "of the deleted one too";
    BecomeCopy();
    Restart();
    EXPECT_TRUE(logger_.All("scene_refused").empty());
    ExpectAsBefore();
    EXPECT_EQ(client_->FindScene("other")->content_hash, other_before_.content_hash);
  }

  SceneInfo other_before_;
};

TEST_F(ReplacedScenesTest, AnExportHasAllThatIsAcknowledged) {
  const Records records = Export("busy");
  ArchiveOrder order({});
  Revision revision = 0;
  for (const v1::ArchiveRecord& record : records) {
    ASSERT_EQ(order.Take(record).status(), absl::OkStatus());
    if (!record.has_commit()) continue;
    EXPECT_EQ(record.commit().revision(), ++revision);
  }
  EXPECT_TRUE(order.has_ended());
  EXPECT_EQ(revision, before_.revision) << "from the first to the last";
  EXPECT_EQ(order.head().content_hash, before_.content_hash);
}

TEST_F(ReplacedScenesTest, D01ADeletedSceneIsNotThereAgain) {
  Delete();
  DragUntilBusy();
  other_before_ = client_->FindScene("other").value();
  EXPECT_EQ(ScenesInCopiedJournal(), 2u) << "of the deleted one too";
  BecomeCopy();
  Restart();
  EXPECT_EQ(client_->FindScene("busy").status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(client_->FindScene("other")->content_hash, other_before_.content_hash);
  EXPECT_EQ(client_->FindScene("other")->revision, other_before_.revision);
  EXPECT_EQ(client_->CreateScene("busy"), absl::OkStatus());
}

TEST_F(ReplacedScenesTest, D01ASceneMadeAnewHasNothingOfTheEarlierOne) {
  const std::string key = KeyOf(drags_);
  Delete();
  ASSERT_EQ(client_->CreateScene("busy"), absl::OkStatus());
  session_ = client_->OpenSession("busy");
  ASSERT_EQ(session_->Commit(StudioDelta()).revision(), 1u);
  CrashWithBoth();
  session_ = client_->OpenSession("busy");
  EXPECT_EQ(session_->Commit(MoveBox({5, 1, 0}), key).revision(), before_.revision + 1)
      << "a key of the earlier one stands for nothing";
}

TEST_F(ReplacedScenesTest, D01ASceneMadeAnewAndLeftAloneHasNothingOfTheEarlierOne) {
  Delete();
  ASSERT_EQ(client_->CreateScene("busy"), absl::OkStatus());
  Copy();
  BecomeCopy();
  Restart();
  EXPECT_TRUE(logger_.All("scene_refused").empty());
  EXPECT_EQ(client_->FindScene("busy")->revision, 0u);
}

TEST_F(ReplacedScenesTest, D01AnArchiveInTheSceneOfTheEarliersIdGoesOnFromWhereItWas) {
  const Records records = WithoutBytesOfBlobs(Export("busy"));
  const SceneInfo exported = client_->FindScene("busy").value();
  for (int i = 0; i < 10; ++i) Drag();  // which the archive does not have
  Delete();
  ImportCall import(*client_);
  ASSERT_TRUE(import.Send("busy", records));
  ASSERT_EQ(import.End(), absl::OkStatus());
  EXPECT_EQ(client_->FindScene("busy")->revision, exported.revision);
  EXPECT_EQ(client_->FindScene("busy")->content_hash, exported.content_hash);
  session_ = client_->OpenSession("busy");
  EXPECT_EQ(session_->Commit(MoveBox({5, 1, 0})).revision(), exported.revision + 1);
  CrashWithBoth();
}

}  // namespace
}  // namespace penumbra::testing
