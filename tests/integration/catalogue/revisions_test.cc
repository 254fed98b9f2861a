// Rows B05 to B14: what order makes of commits.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "proto/convert/scene_convert.h"
#include "render/scene/blob.h"
#include "tests/integration/catalogue/catalogue_test.h"

namespace penumbra::testing {
namespace {

using RevisionRowsTest = CatalogueTest;

SceneDelta On(Revision base, SceneDelta delta) {
  delta.base_revision = base;
  return delta;
}

v1::SessionRequest CommitRequest(uint64_t id, const SceneDelta& delta) {
  v1::SessionRequest request;
  request.mutable_commit()->set_commit_id(id);
  *request.mutable_commit()->mutable_delta() = ToProto(delta);
  return request;
}

TEST_F(RevisionRowsTest, B05WhatIsLainOnIsNotTakenAway) {
  const auto square = MeshOf(UnitSquareGeometry());
  mirror_.Know(square);
  ASSERT_EQ(client_->Upload(*square), absl::OkStatus());
  SceneDelta delta;
  delta.upsert_instances = {{.id = "table", .mesh = square, .world_from_mesh = Placed({0, 1, 3})}};
  delta.upsert_receivers = {
      {.id = "top", .shape = PlanarInstance{"table"}, .width = 8, .height = 8}};
  ASSERT_FALSE(session_->Commit(delta).has_error());
  SceneDelta removal;
  removal.remove_instances = {"table"};
  ExpectRefused(ToProto(removal),
                {absl::StatusCode::kFailedPrecondition, "MISSING_INSTANCE", "remove_instances[0]"});
  // A mesh has no call that takes it away; what is in use stays, and both may go at once.
  EXPECT_TRUE(client_->FindMissing({ToProto(square->id())})->empty());
  removal.remove_receivers = {"top"};
  EXPECT_FALSE(session_->Commit(removal).has_error());
}

TEST_F(RevisionRowsTest, B06TheRefusalNamesTheHeadToTryAgainOn) {
  auto other = client_->OpenSession("studio");
  ASSERT_EQ(session_->Commit(On(1, MoveBox({1, 1, 0}))).revision(), 2u);
  const auto refused = other->Commit(On(1, MoveBox({-1, 1, 0})));
  EXPECT_EQ(FromProto(refused.error()).code(), absl::StatusCode::kAborted);
  EXPECT_EQ(ErrorReason(FromProto(refused.error())), "STALE_BASE");
  EXPECT_EQ(refused.revision(), 2u);
  EXPECT_EQ(other->Commit(On(refused.revision(), MoveBox({-1, 1, 0}))).revision(), 3u);
}

TEST_F(RevisionRowsTest, B08ARepeatedCommitIsAppliedOnce) {
  const auto first = session_->Commit(MoveBox({1, 1, 1}), "key-1");
  session_->Commit(MoveBox({2, 1, 1}));
  const auto in_order = session_->Commit(MoveBox({1, 1, 1}), "key-1");
  auto reconnected = client_->OpenSession("studio");
  const auto again = reconnected->Commit(MoveBox({1, 1, 1}), "key-1");
  for (const auto& answer : {in_order, again}) {
    EXPECT_EQ(answer.revision(), first.revision());
    EXPECT_EQ(answer.content_hash(), first.content_hash());
  }
  EXPECT_EQ(client_->FindScene("studio")->revision, 3u);
}

TEST_F(RevisionRowsTest, B09AKeyStandsForOneDelta) {
  session_->Commit(MoveBox({1, 1, 1}), "key-1");
  ExpectRefused(
      [&] {
        return FromProto(session_->Commit(MoveBox({3, 1, 1}), "key-1").error());
      },
      {absl::StatusCode::kInvalidArgument, "REQUEST_ID_REUSED", "idempotency_key"});
}

TEST(RepeatedCommitTest, B08GetsItsAnswerAfterItsMeshesAreGone) {
  ServerOptions options;
  options.limits.unused_blob_lifetime = std::chrono::seconds(0);
  options.limits.max_blob_store_bytes = EncodeBlob(BoxMesh()->geometry()).size() + 100;
  const auto server = StartServer(options);
  WireClient client(server->address());
  ASSERT_EQ(client.CreateScene("studio"), absl::OkStatus());
  ASSERT_EQ(client.Upload(*BoxMesh()), absl::OkStatus());
  auto session = client.OpenSession("studio");
  const auto first = session->Commit(StudioDelta(), "key");
  ASSERT_EQ(first.revision(), 1u);
  SceneDelta removal;
  removal.remove_instances = {"box"};
  ASSERT_EQ(session->Commit(removal).revision(), 2u);
  std::this_thread::sleep_for(std::chrono::milliseconds(10));
  ASSERT_EQ(client.Upload(*MeshOf(UnitSquareGeometry())), absl::OkStatus());
  ASSERT_EQ(client.FindMissing({ToProto(BoxMesh()->id())})->size(), 1u) << "it had to make room";

  const auto again = session->Commit(StudioDelta(), "key");
  EXPECT_FALSE(again.has_error()) << again.error().message();
  EXPECT_EQ(again.revision(), 1u);
  EXPECT_EQ(again.content_hash(), first.content_hash());
  const absl::Status other = FromProto(session->Commit(StudioDelta(64), "key").error());
  EXPECT_EQ(ErrorReason(other), "REQUEST_ID_REUSED");
  const absl::Status fresh = FromProto(session->Commit(StudioDelta(), "another-key").error());
  EXPECT_EQ(ErrorReason(fresh), "MISSING_BLOB");
}

// Sent at once, and not in the order that their bases have.
TEST_F(RevisionRowsTest, B10DeltasOutOfOrderAreRefusedAndTheStreamGoesOn) {
  const Revision bases[] = {2, 1, 1, 3, 2};
  for (uint64_t i = 0; i < std::size(bases); ++i) {
    session_->Send(CommitRequest(100 + i, On(bases[i], MoveBox({0.1f * i, 1, 0}))));
  }
  std::vector<std::string> reasons;
  for (uint64_t i = 0; i < std::size(bases); ++i) {
    const auto answer = session_->ReadUntil(v1::SessionResponse::kCommitResult)->commit_result();
    EXPECT_EQ(answer.commit_id(), 100 + i) << "answers come in the order of the requests";
    reasons.push_back(ErrorReason(FromProto(answer.error())));
  }
  EXPECT_THAT(reasons, ::testing::ElementsAre("FUTURE_BASE", "", "STALE_BASE", "FUTURE_BASE", ""));
  EXPECT_EQ(client_->FindScene("studio")->revision, 3u);
}

// One object, and a base that only one of all can meet.
TEST_F(RevisionRowsTest, B14OfWritersOnOneBaseOneWins) {
  std::atomic<int> won = 0, lost = 0;
  std::vector<std::thread> writers;
  for (int i = 0; i < 16; ++i) {
    writers.emplace_back([&, i] {
      WireClient client(server_->address());
      auto session = client.OpenSession("studio");
      const auto result = session->Commit(On(1, MoveBox({0.1f * i, 1, 0})));
      won += !result.has_error();
      lost += ErrorReason(FromProto(result.error())) == "STALE_BASE" && result.revision() == 2;
    });
  }
  for (std::thread& writer : writers) writer.join();
  EXPECT_EQ(won, 1);
  EXPECT_EQ(lost, 15);
}

// Every writer tries again on the head that its refusal names until it is in. Each commit that was
// acknowledged has a revision of its own, and whoever watches sees them in that order.
TEST_F(RevisionRowsTest, B14SixtyFourWritersMakeOneOrder) {
  constexpr int kWriters = 64, kEach = 3;
  std::mutex mutex;
  std::map<uint64_t, std::string> hashes;  // by the revision that was answered
  std::vector<std::thread> writers;
  for (int w = 0; w < kWriters; ++w) {
    writers.emplace_back([&, w] {
      WireClient client(server_->address());
      auto session = client.OpenSession("studio");
      Revision base = 1;
      for (int done = 0; done < kEach;) {
        const auto result = session->Commit(On(base, MoveBox({0.01f * w, 1, 0.1f * (done + 1)})));
        base = result.revision();
        if (result.has_error()) {
          ASSERT_EQ(ErrorReason(FromProto(result.error())), "STALE_BASE");
          continue;
        }
        ++done;
        std::lock_guard lock(mutex);
        EXPECT_TRUE(hashes.emplace(result.revision(), result.content_hash()).second);
      }
    });
  }
  for (std::thread& writer : writers) writer.join();
  ASSERT_EQ(hashes.size(), size_t{kWriters * kEach});
  EXPECT_EQ(hashes.begin()->first, 2u);
  EXPECT_EQ(hashes.rbegin()->first, 1u + kWriters * kEach) << "without gaps";
  EXPECT_EQ(ToProto(client_->FindScene("studio")->content_hash), hashes.rbegin()->second);
  while (mirror_.revision < hashes.rbegin()->first) {
    mirror_.Apply(bystander_->ReadUntil(v1::SessionResponse::kSceneUpdate)->scene_update());
    EXPECT_EQ(ToProto(mirror_.scene->content_hash()), hashes[mirror_.revision]);
  }
}

}  // namespace
}  // namespace penumbra::testing
