// Rows B11, C14, C16 and C17: clients that hurry, and clients that go away in the middle.

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <thread>

#include "proto/convert/scene_convert.h"
#include "proto/convert/spec_convert.h"
#include "render/scene/blob.h"
#include "tests/integration/catalogue/catalogue_test.h"

namespace penumbra::testing {
namespace {

using std::chrono::milliseconds, std::chrono::seconds, std::chrono::steady_clock;

v1::SessionRequest CommitRequest(uint64_t id, const SceneDelta& delta, const std::string& key) {
  v1::SessionRequest request;
  request.mutable_commit()->set_commit_id(id);
  *request.mutable_commit()->mutable_delta() = ToProto(delta);
  request.mutable_commit()->set_idempotency_key(key);
  return request;
}

class CancelRowsTest : public CatalogueTest {
 protected:
  v1::ServerStatistics Statistics() { return client_->ServerInfo().statistics(); }

  // Whether it comes to that in time.
  template <typename Condition>
  static bool Comes(Condition condition, milliseconds limit = kPatience) {
    for (const auto end = steady_clock::now() + limit; steady_clock::now() < end;) {
      if (condition()) return true;
      std::this_thread::sleep_for(milliseconds(2));
    }
    return condition();
  }
  uint64_t JobsUnderWay() {
    grpc::ClientContext context;
    v1::GetServerStatusResponse response;
    EXPECT_TRUE(
        client_->stub().GetServerStatus(&context, v1::GetServerStatusRequest(), &response).ok());
    uint64_t jobs = 0;
    for (const auto& scene : response.scenes()) jobs += scene.jobs_running() + scene.jobs_waiting();
    return jobs;
  }
  // Minutes of work: the box's top fills the picture.
  static ArtifactSpec LongSpec() {
    const Camera above{.eye = {0, 1.9f, 0.1f}, .target = {0, 1, 0}};
    return {.params = CoherentRaytraceParams{.samples = 1'024, .coherence = false},
            .light_id = "lamp",
            .points = PicturePixels{.camera = above, .width = 2'048, .height = 2'048}};
  }
};

TEST_F(CancelRowsTest, B11HalfAnUploadWhoseClientGoesAwayIsDiscarded) {
  const auto blob = EncodeBlob(BallGeometry(64, 64));
  const auto before = Statistics();
  v1::UploadBlobRequest half;
  half.mutable_header()->set_hash(std::string(32, 'h'));
  half.mutable_header()->set_size_bytes(blob.size());
  half.set_data(blob.data(), blob.size() / 2);
  grpc::ClientContext context;
  v1::UploadBlobResponse response;
  const auto writer = client_->stub().UploadBlob(&context, &response);
  ASSERT_TRUE(writer->Write(half));
  EXPECT_TRUE(Comes([&] { return Statistics().blob_bytes() > before.blob_bytes(); }))
      << "it counts as long as it is under way";
  context.TryCancel();
  EXPECT_EQ(writer->Finish().error_code(), grpc::StatusCode::CANCELLED);
  EXPECT_TRUE(Comes([&] { return Statistics().blob_bytes() == before.blob_bytes(); }));
  EXPECT_EQ(Statistics().blobs(), before.blobs());
}

// Each is answered, in order, whatever is left out of what is shown of them.
TEST_F(CancelRowsTest, C14CommitsFasterThanShadowsAreAllAnswered) {
  constexpr uint64_t kCommits = 400, kAtATime = 50;
  SceneDelta larger;
  larger.upsert_receivers = {FloorReceiver("other", 4, 1'024)};
  ASSERT_EQ(session_->Commit(larger).revision(), 2u);
  ArtifactSpec spec = FloorSpec(256);
  spec.receiver_id = "other";
  ASSERT_EQ(session_->Subscribe(5, spec, 1'000'000), absl::OkStatus());
  for (uint64_t first = 0; first < kCommits; first += kAtATime) {
    for (uint64_t i = first; i < first + kAtATime; ++i) {
      session_->Send(CommitRequest(1'000 + i, MoveBox({0.002f * i, 1, 0}), ""));
    }
    for (uint64_t i = first; i < first + kAtATime; ++i) {
      const auto answer = session_->ReadUntil(v1::SessionResponse::kCommitResult);
      ASSERT_TRUE(answer);
      EXPECT_EQ(answer->commit_result().commit_id(), 1'000 + i);
      EXPECT_EQ(answer->commit_result().revision(), 3 + i);
    }
  }
  uint64_t updates = 0;
  Revision newest = 0;
  const auto last = session_->AwaitUpdate(5, [&](const ArtifactUpdate& update) {
    ++updates;
    if (!update.artifact) return false;
    EXPECT_GE(update.revision, newest) << "what an update says it covers only grows";
    EXPECT_LE(update.artifact->header.revision, update.revision);
    newest = update.revision;
    return IsFinal(update) && update.revision == 2 + kCommits;
  });
  EXPECT_TRUE(last.artifact);
  EXPECT_LT(updates, kCommits) << "it skips, it does not queue";
}

// Before there is a welcome, after it, and after the answer. A commit that was cut off is there or
// is not, and its key tells: sent again it is applied once in all.
TEST_F(CancelRowsTest, C16CommitsThatAreCancelledAreAppliedOrNot) {
  constexpr int kSessions = 150;
  for (int i = 0; i < kSessions; ++i) {
    WireSession session(client_->stub());
    v1::SessionRequest hello;
    hello.mutable_hello()->add_protocol_versions(1);
    hello.mutable_hello()->set_scene_id("studio");
    session.Send(hello);
    if (i % 3 > 0) {
      ASSERT_TRUE(session.ReadUntil(v1::SessionResponse::kWelcome));
    }
    session.Send(CommitRequest(1, MoveBox({0.01f * i, 1, 0}), "key" + std::to_string(i)));
    if (i % 3 > 1) {
      ASSERT_TRUE(session.ReadUntil(v1::SessionResponse::kCommitResult));
    }
    session.Cancel();
  }
  EXPECT_TRUE(Comes([&] { return Statistics().open_sessions() == 2; })) << "nothing is left over";
  const Revision applied = client_->FindScene("studio")->revision - 1;
  EXPECT_GE(applied, Revision{kSessions / 3}) << "those that were answered";
  EXPECT_LE(applied, Revision{kSessions});
  for (int i = 0; i < kSessions; ++i) {
    const auto answer = session_->Commit(MoveBox({0.01f * i, 1, 0}), "key" + std::to_string(i));
    EXPECT_FALSE(answer.has_error()) << answer.error().message();
  }
  EXPECT_EQ(client_->FindScene("studio")->revision, Revision{1 + kSessions});
}

TEST_F(CancelRowsTest, C16WorkForWhoHasGoneStopsAtOnce) {
  const ArtifactSpec spec = LongSpec();
  milliseconds soonest = kPatience;
  for (int i = 0; i < 5; ++i) {
    auto leaver = client_->OpenSession("studio");
    ASSERT_EQ(leaver->Subscribe(1, spec, 4), absl::OkStatus());
    ASSERT_TRUE(Comes([&] { return JobsUnderWay() > 0; }));
    std::this_thread::sleep_for(milliseconds(50));
    const auto start = steady_clock::now();
    leaver.reset();
    ASSERT_TRUE(Comes([&] { return JobsUnderWay() == 0; }));
    soonest =
        std::min(soonest, std::chrono::duration_cast<milliseconds>(steady_clock::now() - start));
  }
  EXPECT_LE(soonest, milliseconds(100));
  EXPECT_TRUE(Comes([&] { return Statistics().open_subscriptions() == 1; })) << "the bystander's";
}

TEST_F(CancelRowsTest, C17ADeadlineThatPassesEndsTheCallAndItsWork) {
  const ArtifactSpec spec = LongSpec();
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + seconds(3));
  const auto stream = client_->stub().Session(&context);
  v1::SessionRequest request;
  request.mutable_hello()->add_protocol_versions(1);
  request.mutable_hello()->set_scene_id("studio");
  ASSERT_TRUE(stream->Write(request));
  request.mutable_subscribe()->set_subscription_id(1);
  request.mutable_subscribe()->set_initial_credit(1'000);
  *request.mutable_subscribe()->mutable_spec() = ToProto(spec);
  ASSERT_TRUE(stream->Write(request));
  EXPECT_TRUE(Comes([&] { return JobsUnderWay() > 0; }, milliseconds(2'500)));
  v1::SessionResponse response;
  while (stream->Read(&response)) {
  }
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
  EXPECT_TRUE(Comes([&] { return JobsUnderWay() == 0; }, seconds(2)));
  EXPECT_TRUE(Comes([&] { return Statistics().open_sessions() == 2; }));
}

}  // namespace
}  // namespace penumbra::testing
