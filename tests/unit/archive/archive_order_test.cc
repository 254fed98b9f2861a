// The records of an archive in the right order, and in others.
#include "proto/archive/archive_order.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "proto/archive/base_pieces.h"
#include "render/scene/field_error.h"
#include "tests/support/small_archive.h"

namespace penumbra::testing {
namespace {

using Records = std::vector<v1::ArchiveRecord>;

// The first error, or whether all is there.
absl::Status Read(const Records& records, const ArchiveOrderOptions& options = {}) {
  ArchiveOrder order(options);
  for (const auto& record : records) {
    if (auto status = order.Take(record).status(); !status.ok()) return status;
  }
  return order.has_ended() ? absl::OkStatus() : absl::DataLossError("no end");
}

TEST(ArchiveOrderTest, TellsWhatEachRecordCompletes) {
  ArchiveOrder order({});
  std::string kinds;
  for (const auto& record : SmallArchive(7)) {
    const auto step = order.Take(record);
    ASSERT_EQ(step.status(), absl::OkStatus());
    kinds += std::to_string(step->index());
    if (const auto* commit = std::get_if<CommitRecord>(&*step)) {
      EXPECT_EQ(commit->delta, record.data());
      EXPECT_EQ(commit->author, "tester");
    }
    if (const auto* blob = std::get_if<ArchivedBlob>(&*step)) {
      EXPECT_EQ(blob->bytes.size(), blob->size_bytes);
    }
  }
  EXPECT_EQ(kinds,
            "10234445"
            "")
      << "a head, half a blob, its rest, the base, commits, the end";
  EXPECT_TRUE(order.has_ended());
  EXPECT_EQ(order.head().revision, 10u);
}

struct Fault {
  const char* what;
  const char* reason;
  std::function<void(Records&)> make;
};

// Of the archive with a base: 0 head, 1 and 2 blob, 3 base, 4 to 6 commits, 7 end.
const Fault kFaults[] = {
    {"no head", "ARCHIVE_ORDER", [](Records& r) { r.erase(r.begin()); }},
    {"two heads", "ARCHIVE_ORDER", [](Records& r) { r.insert(r.begin(), r[0]); }},
    {"a newer format", "VERSION", [](Records& r) { r[0].mutable_head()->set_format_version(2); }},
    {"a bad id", "BAD_ID", [](Records& r) { r[0].mutable_head()->set_scene_id("../x"); }},
    {"a short hash", "LENGTH", [](Records& r) { r[0].mutable_head()->set_chain("x"); }},
    {"a head before its base", "RANGE", [](Records& r) { r[0].mutable_head()->set_revision(6); }},
    {"a revision that nobody reaches", "RANGE",
     [](Records& r) {
       r[0].mutable_head()->set_base_revision(std::numeric_limits<int64_t>::max());
       r[0].mutable_head()->set_revision(std::numeric_limits<int64_t>::max());
     }},
    {"no blob", "ARCHIVE_ORDER", [](Records& r) { r.erase(r.begin() + 1, r.begin() + 3); }},
    {"a blob twice", "ARCHIVE_ORDER",
     [](Records& r) {
       r.insert(r.begin() + 3, {v1::ArchiveRecord(r[1]), r[2]});
     }},
    {"half a blob", "LENGTH", [](Records& r) { r.erase(r.begin() + 2); }},
    {"too much of a blob", "LENGTH", [](Records& r) { r[2].mutable_data()->append("x"); }},
    {"a blob of nothing", "LENGTH", [](Records& r) { r[1].mutable_blob()->set_size_bytes(0); }},
    {"bytes of nothing", "ARCHIVE_ORDER", [](Records& r) { r.insert(r.begin() + 3, r[2]); }},
    {"no base", "ARCHIVE_ORDER", [](Records& r) { r.erase(r.begin() + 3); }},
    {"two bases", "ARCHIVE_ORDER", [](Records& r) { r.insert(r.begin() + 3, r[3]); }},
    {"bytes of a base", "LENGTH", [](Records& r) { r[3].set_data("x"); }},
    {"a commit missing", "ARCHIVE_ORDER", [](Records& r) { r.erase(r.begin() + 5); }},
    {"commits exchanged", "ARCHIVE_ORDER", [](Records& r) { std::swap(r[4], r[5]); }},
    {"the last commit missing", "ARCHIVE_ORDER", [](Records& r) { r.erase(r.begin() + 6); }},
    {"another author", "HASH_MISMATCH",
     [](Records& r) { r[5].mutable_commit()->set_author_name("somebody"); }},
    {"another time", "HASH_MISMATCH", [](Records& r) { r[5].mutable_commit()->set_time_ms(1); }},
    {"another key", "HASH_MISMATCH",
     [](Records& r) { r[5].mutable_commit()->set_idempotency_key(""); }},
    {"another delta", "HASH_MISMATCH",
     [](Records& r) { r[5].mutable_data()->at(3) = static_cast<char>(r[5].data()[3] ^ 1); }},
    {"another base chain", "HASH_MISMATCH",
     [](Records& r) { r[0].mutable_head()->set_base_chain(r[0].head().chain()); }},
    {"another last chain", "HASH_MISMATCH",
     [](Records& r) { r[0].mutable_head()->set_chain(r[0].head().base_chain()); }},
    {"another content", "HASH_MISMATCH",
     [](Records& r) { r[0].mutable_head()->set_content_hash(r[0].head().chain()); }},
    {"something after the end", "ARCHIVE_ORDER", [](Records& r) { r.push_back(r[6]); }},
};

TEST(ArchiveOrderTest, WhatIsOutOfOrderIsRefusedWithItsPlace) {
  ASSERT_EQ(Read(SmallArchive(7)), absl::OkStatus());
  ASSERT_EQ(Read(SmallArchive()), absl::OkStatus());
  for (const Fault& fault : kFaults) {
    Records records = SmallArchive(7);
    fault.make(records);
    const absl::Status status = Read(records);
    EXPECT_EQ(ErrorReason(status), fault.reason) << fault.what << ": " << status;
    EXPECT_THAT(ErrorFieldPath(status), ::testing::StartsWith("records[")) << fault.what;
  }
}

TEST(ArchiveOrderTest, ARevisionIsAtMostTheLast) {
  EXPECT_EQ(Read(SmallArchive(kMaxArchivedRevision - 3)), absl::OkStatus());
  const absl::Status status = Read(SmallArchive(kMaxArchivedRevision - 2));
  EXPECT_EQ(ErrorReason(status), "RANGE");
  EXPECT_EQ(ErrorFieldPath(status), "records[0].revision");
}

TEST(ArchiveOrderTest, LimitsAreOfWhatIsAnnounced) {
  EXPECT_EQ(ErrorReason(Read(SmallArchive(), {.max_blob_bytes = 200})), "QUOTA_BLOB_BYTES");
  EXPECT_EQ(ErrorReason(Read(SmallArchive(), {.max_delta_bytes = 20})), "QUOTA_DELTA_BYTES");
}

TEST(ArchiveOrderTest, BlobsWithoutTheirBytesAreNames) {
  Records records = SmallArchive();
  records.erase(records.begin() + 2);
  records[1].clear_data();
  EXPECT_EQ(Read(records, {.has_blob_bytes = false}), absl::OkStatus());
  EXPECT_EQ(ErrorReason(Read(SmallArchive(), {.has_blob_bytes = false})), "LENGTH");
}

TEST(BasePiecesTest, PiecesPutTogetherAreTheWhole) {
  v1::SceneDelta whole;
  for (int i = 0; i < 100; ++i) {
    whole.add_upsert_instances()->set_id("instance-" + std::to_string(i));
    whole.add_upsert_lights()->set_id("light-" + std::to_string(i));
    whole.add_upsert_receivers()->set_id("receiver-" + std::to_string(i));
  }
  const auto pieces = BasePieces(whole, 256);
  EXPECT_GT(pieces.size(), 10u);
  v1::SceneDelta together;
  for (size_t i = 0; i < pieces.size(); ++i) {
    EXPECT_EQ(pieces[i].is_continued(), i + 1 < pieces.size());
    EXPECT_LE(pieces[i].delta().ByteSizeLong(), 256u);
    together.MergeFrom(pieces[i].delta());
  }
  EXPECT_EQ(together.SerializeAsString(), whole.SerializeAsString());
  EXPECT_EQ(BasePieces({}, 256).size(), 1u) << "of an empty scene too";
}

}  // namespace
}  // namespace penumbra::testing
