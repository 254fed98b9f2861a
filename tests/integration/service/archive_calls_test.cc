// ImportScene and ExportScene as calls: what a client can send that is no archive, and how much.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <thread>

#include "proto/archive/archive_order.h"
#include "proto/convert/status_convert.h"
#include "render/scene/field_error.h"
#include "tests/integration/service/import_call.h"

namespace penumbra::testing {
namespace {

namespace fs = std::filesystem;

class ArchiveCallsTest : public ImportTest {
 protected:
  void ExpectNothing(const char* what) {
    EXPECT_TRUE(client_->ListScenes()->empty()) << what;
    EXPECT_TRUE(fs::is_empty(folder_ / "data/scenes")) << what;
  }
};

TEST_F(ArchiveCallsTest, RecordsMakeASceneAtTheirRevision) {
  for (const Revision base : {0, 7}) {
    const std::string id = base > 0 ? "with-base" : "from-nothing";
    ASSERT_EQ(Import(SmallImport(base), id), absl::OkStatus());
    EXPECT_EQ(client_->FindScene(id)->revision, base + 3);
    session_ = client_->OpenSession(id);
    EXPECT_EQ(ErrorReason(ErrorIn(session_->Commit(MoveBox({0, 1, 0}), "key-2"))),
              "REQUEST_ID_REUSED")
        << "keys of the archive's commits are known";
    EXPECT_EQ(session_->Commit(MoveBox({0, 1, 0})).revision(), base + 4);
  }
  const auto hash = client_->FindScene("with-base")->content_hash;
  Restart();
  EXPECT_EQ(client_->FindScene("with-base")->content_hash, hash);
  EXPECT_EQ(client_->FindScene("from-nothing")->revision, 4u);
}

TEST_F(ArchiveCallsTest, AtTheLastRevisionASceneGoesOnAndIsThereAgain) {
  ASSERT_EQ(Import(SmallImport(kMaxArchivedRevision - 3)), absl::OkStatus());
  session_ = client_->OpenSession("studio");
  EXPECT_EQ(session_->Commit(MoveBox({0, 1, 0})).revision(), kMaxArchivedRevision + 1);
  Restart();
  EXPECT_EQ(client_->FindScene("studio")->revision, kMaxArchivedRevision + 1);
}

TEST_F(ArchiveCallsTest, OneRecordAMessageMakesTheSame) {
  ImportCall call(*client_);
  std::string id = "studio";
  for (const auto& record : SmallImport(7)) {
    ASSERT_TRUE(call.Send(id, {record}));
    id.clear();
  }
  EXPECT_EQ(client_->ListScenes()->size(), 0u) << "not before all of it is there";
  ASSERT_EQ(call.End(), absl::OkStatus());
  EXPECT_EQ(call.scene().revision(), 10u);
}

struct Fault {
  const char* what;
  absl::StatusCode code;
  const char* reason;
  const char* field;
  std::function<void(Records&)> make;
};

void PutDelta(Records& records, const v1::SceneDelta& delta, const std::string& bytes = {}) {
  records[4].set_data(bytes.empty() ? delta.SerializeAsString() : bytes);
  TieAnew(records);
}

// Of the archive without a base: 0 head, 1 blob, 2 to 4 commits, 5 end.
const Fault kFaults[] = {
    {"cut", absl::StatusCode::kInvalidArgument, "LENGTH", "records",
     [](Records& r) { r.pop_back(); }},
    {"nothing", absl::StatusCode::kInvalidArgument, "LENGTH", "records",
     [](Records& r) { r.clear(); }},
    {"another commit", absl::StatusCode::kInvalidArgument, "HASH_MISMATCH", "records[3]",
     [](Records& r) { r[3].mutable_commit()->set_author_name("x"); }},
    {"another scene", absl::StatusCode::kInvalidArgument, "HASH_MISMATCH",
     "records[4].content_hash", [](Records& r) { PutDelta(r, ToProto(BoxAndLamp(9))); }},
    {"a delta that is none", absl::StatusCode::kInvalidArgument, "MALFORMED", "records[4].delta",
     [](Records& r) { PutDelta(r, {}, "\xff\xff\xff"); }},
    {"a delta that depends on more", absl::StatusCode::kInvalidArgument, "UNEXPECTED_FIELD",
     "records[4].delta",
     [](Records& r) {
       v1::SceneDelta delta;
       delta.mutable_receive_on_planar_surfaces();
       PutDelta(r, delta);
     }},
    {"a delta of sub-messages", absl::StatusCode::kResourceExhausted, "QUOTA_ELEMENTS",
     "records[4].delta",
     [](Records& r) {
       std::string bytes;
       for (int i = 0; i < 400'000; ++i) bytes += std::string("\x22\x00", 2);
       PutDelta(r, {}, bytes);
     }},
    {"a removal of what is not there", absl::StatusCode::kNotFound, "UNKNOWN_ID",
     "records[4].delta.remove_lights[0]",
     [](Records& r) {
       v1::SceneDelta delta;
       delta.add_remove_lights("none");
       PutDelta(r, delta);
     }},
    {"a blob that is not here", absl::StatusCode::kFailedPrecondition, "MISSING_BLOB",
     "records[1].hash", [](Records& r) { r[1].mutable_blob()->set_hash(std::string(32, 'x')); }},
    {"a mesh that the archive does not name", absl::StatusCode::kFailedPrecondition, "MISSING_BLOB",
     "records[1].delta.upsert_instances[0].mesh_hash",
     [](Records& r) {
       r.erase(r.begin() + 1);
       r[0].mutable_head()->set_blob_count(0);
     }},
    {"bytes of a blob", absl::StatusCode::kInvalidArgument, "LENGTH", "records[1]",
     [](Records& r) { r[1].set_data("x"); }},
    {"a revision that would be negative on disk", absl::StatusCode::kInvalidArgument, "RANGE",
     "records[0].revision",
     [](Records& r) {
       r[0].mutable_head()->set_base_revision(std::numeric_limits<int64_t>::max());
       r[0].mutable_head()->set_revision(std::numeric_limits<int64_t>::max());
     }},
    {"a newer format", absl::StatusCode::kFailedPrecondition, "VERSION",
     "records[0].format_version", [](Records& r) { r[0].mutable_head()->set_format_version(2); }},
};

TEST_F(ArchiveCallsTest, WhatIsNoArchiveMakesNothing) {
  for (const Fault& fault : kFaults) {
    Records records = SmallImport();
    fault.make(records);
    const absl::Status status = Import(records);
    EXPECT_EQ(status.code(), fault.code) << fault.what << ": " << status;
    EXPECT_EQ(ErrorReason(status), fault.reason) << fault.what << ": " << status;
    EXPECT_EQ(ErrorFieldPath(status), fault.field) << fault.what << ": " << status;
    ExpectNothing(fault.what);
  }
  EXPECT_EQ(Import(SmallImport()), absl::OkStatus()) << "and the id is still free";
}

TEST_F(ArchiveCallsTest, B01BadIdsAreRefused) {
  for (const char* id : {"", "../x", "a b", "\n"}) {
    EXPECT_EQ(ErrorReason(Import(SmallImport(), id)), "BAD_ID") << id;
  }
  ImportCall call(*client_);
  call.Send("studio", {});
  call.Send("studio", {});
  EXPECT_EQ(ErrorReason(call.End()), "UNEXPECTED_FIELD");
  EXPECT_EQ(ErrorReason(ImportCall(*client_).End()), "MISSING_FIELD");
  ExpectNothing("bad ids");
}

TEST_F(ArchiveCallsTest, C16ACancelledImportLeavesNothing) {
  Records records = SmallImport(7);
  records.pop_back();
  {
    ImportCall call(*client_);
    ASSERT_TRUE(call.Send("studio", records));
    // It has the id while it lasts.
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    EXPECT_EQ(client_->CreateScene("studio").code(), absl::StatusCode::kAlreadyExists);
    EXPECT_EQ(Import(SmallImport()).code(), absl::StatusCode::kAlreadyExists);
    call.Cancel();
    EXPECT_EQ(call.End().code(), absl::StatusCode::kCancelled);
  }
  absl::Status status;
  for (int i = 0; i < 200; ++i) {
    status = Import(SmallImport());
    if (status.ok()) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_EQ(status, absl::OkStatus());
  EXPECT_EQ(client_->ListScenes()->size(), 1u);
}

// It has sent all, the end included, and what the server reads after that is the end of the call.
TEST_F(ArchiveCallsTest, C16AnImportThatIsCancelledAfterItsLastRecordLeavesNothing) {
  for (int i = 0; i < 20; ++i) {
    ImportCall call(*client_);
    const std::string id = "studio-" + std::to_string(i);
    ASSERT_TRUE(call.Send(id, SmallImport(7)));
    std::this_thread::sleep_for(std::chrono::milliseconds(100));  // until the server has it
    call.Cancel();
    EXPECT_EQ(call.End().code(), absl::StatusCode::kCancelled);
  }
  std::this_thread::sleep_for(std::chrono::seconds(1));
  ExpectNothing("cancelled");
}

TEST_F(ArchiveCallsTest, ExportsAndImportsHaveABound) {
  options_.limits.archives.max_transfers = 1;
  Restart();
  ImportCall first(*client_);
  ASSERT_TRUE(first.Send("one", {}));
  std::this_thread::sleep_for(std::chrono::milliseconds(200));  // until it has its turn
  absl::Status refused;
  for (int i = 0; i < 200 && refused.ok(); ++i) {
    ImportCall second(*client_);
    second.Send("two", {});
    refused = second.End();
    if (ErrorReason(refused) == "LENGTH") refused = absl::OkStatus();  // it came first
  }
  EXPECT_EQ(ErrorReason(refused), "QUOTA_ARCHIVES") << refused;
  EXPECT_EQ(refused.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_FALSE(first.End().ok());
  EXPECT_EQ(ErrorReason(Import({})), "LENGTH") << "its turn is given back";
}

TEST_F(ArchiveCallsTest, WhatACrashLeftOfAnImportGoes) {
  server_.reset();
  const std::string left = folder_ / "data/scenes/studio~1.db.import";
  std::ofstream(left) << "half a file";
  std::ofstream(left + "-wal") << "and its log";
  std::ofstream(folder_ / "data/scenes/x.db.import~1.db") << "a scene of that name";
  Restart();
  EXPECT_FALSE(fs::exists(left));
  EXPECT_FALSE(fs::exists(left + "-wal"));
  EXPECT_TRUE(fs::exists(folder_ / "data/scenes/x.db.import~1.db"));
}

TEST_F(ArchiveCallsTest, AnExportIsOfMessagesThatFit) {
  MakeStudio();
  options_.limits.max_message_bytes = 32u << 10;
  Restart();
  v1::ExportSceneRequest request;
  request.set_scene_id("studio");
  grpc::ClientContext context;
  const auto reader = client_->stub().ExportScene(&context, request);
  v1::ExportSceneResponse response;
  ArchiveOrder order({});
  while (reader->Read(&response)) {
    EXPECT_LE(response.ByteSizeLong(), 32u << 10);
    for (const auto& record : response.records()) {
      ASSERT_EQ(order.Take(record).status(), absl::OkStatus());
    }
  }
  EXPECT_EQ(FromGrpcStatus(reader->Finish()), absl::OkStatus());
  EXPECT_TRUE(order.has_ended());
}

}  // namespace
}  // namespace penumbra::testing
