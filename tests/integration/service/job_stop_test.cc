// Whoever wants a computation no longer, in whatever way, has it stopped: the job that runs is told
// to stop at once, and the one that waits never runs. Rows C16 and C17.

#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "proto/convert/spec_convert.h"
#include "tests/integration/service/studio.h"

namespace penumbra::testing {
namespace {

using Clock = std::chrono::steady_clock;
using Ms = std::chrono::duration<double, std::milli>;

// The catalogue asks for 100 ms; the rest is for machines that build beside the test.
constexpr Ms kPromptly{300};

// Computes until it is stopped.
class EndlessTechnique : public Technique {
 public:
  const TechniqueInfo& info() const override { return SoftTextureParams::kInfo; }
  absl::Status Check(const Scene&, const ArtifactSpec&) const override { return absl::OkStatus(); }
  absl::StatusOr<Artifact> Compute(const Scene&, const ArtifactSpec&,
                                   const ComputeContext& context) const override {
    std::unique_lock lock(mutex_);
    ++begun_;
    changed_.notify_all();
    changed_.wait(lock, context.stop, [] { return false; });
    stopped_at_.push_back(Clock::now());
    changed_.notify_all();
    return absl::CancelledError("stopped");
  }

  void AwaitBegun(size_t count) const {
    std::unique_lock lock(mutex_);
    ASSERT_TRUE(changed_.wait_for(lock, kPatience, [&] { return begun_ >= count; }));
  }
  // When job number `index` stopped; none: it does not.
  std::optional<Clock::time_point> AwaitStop(size_t index) const {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, kPatience, [&] { return stopped_at_.size() > index; });
    return stopped_at_.size() > index ? std::optional(stopped_at_[index]) : std::nullopt;
  }
  size_t begun() const {
    std::lock_guard lock(mutex_);
    return begun_;
  }
  size_t stopped() const {
    std::lock_guard lock(mutex_);
    return stopped_at_.size();
  }

 private:
  mutable std::mutex mutex_;
  mutable std::condition_variable_any changed_;
  mutable size_t begun_ = 0;
  mutable std::vector<Clock::time_point> stopped_at_;
};

class JobStopTest : public StudioTest {
 protected:
  JobStopTest() {
    options_.runners = 1;
    options_.technique_for = [this](const TechniqueParams&) -> const Technique& {
      return technique_;
    };
  }
  void SetUp() override {
    StudioTest::SetUp();
    ASSERT_EQ(session_->Subscribe(1, FloorSpec(), 8), absl::OkStatus());
    technique_.AwaitBegun(1);
  }
  void TearDown() override {
    session_.reset();
    server_.reset();  // whose jobs use the technique
  }
  // `since` it is wanted no longer.
  void ExpectStop(Clock::time_point since) {
    const auto stopped = technique_.AwaitStop(0);
    ASSERT_TRUE(stopped);
    EXPECT_LT(Ms(*stopped - since), kPromptly);
  }

  EndlessTechnique technique_;
};

TEST_F(JobStopTest, C16ByCancellingTheCall) {
  const auto since = Clock::now();
  session_->Cancel();
  ExpectStop(since);
}

TEST_F(JobStopTest, C16ByUnsubscribing) {
  const auto since = Clock::now();
  v1::SessionRequest request;
  request.mutable_unsubscribe()->set_subscription_id(1);
  session_->Send(request);
  ExpectStop(since);
  EXPECT_EQ(session_->Commit(MoveBox({1, 1, 0})).revision(), 2u) << "the session goes on";
}

TEST_F(JobStopTest, C16ByGoingAwayWithTheConnection) {
  auto gone = std::make_unique<WireClient>(server_->address());
  auto session = gone->OpenSession("studio");
  // The first one's runs, this one's waits; then this one's runs.
  ASSERT_EQ(session->Subscribe(1, FloorSpec(4), 8), absl::OkStatus());
  session_->Cancel();
  technique_.AwaitBegun(2);
  const auto since = Clock::now();
  session.reset();
  gone.reset();
  const auto stopped = technique_.AwaitStop(1);
  ASSERT_TRUE(stopped);
  EXPECT_LT(Ms(*stopped - since), kPromptly);
}

TEST_F(JobStopTest, C16ByDeletingTheScene) {
  const auto since = Clock::now();
  ASSERT_EQ(client_->DeleteScene("studio"), absl::OkStatus());
  ExpectStop(since);
}

// A deadline that the client has set, and that nobody else keeps.
TEST_F(JobStopTest, C17ByTheDeadlineOfTheCall) {
  session_->Cancel();
  ASSERT_TRUE(technique_.AwaitStop(0));
  grpc::ClientContext context;
  const auto deadline = std::chrono::milliseconds(700);
  const auto begun = Clock::now();
  context.set_deadline(std::chrono::system_clock::now() + deadline);
  const auto stream = client_->stub().Session(&context);
  v1::SessionRequest request;
  request.mutable_hello()->add_protocol_versions(1);
  request.mutable_hello()->set_scene_id("studio");
  stream->Write(request);
  request.mutable_subscribe()->set_subscription_id(1);
  *request.mutable_subscribe()->mutable_spec() = ToProto(FloorSpec());
  stream->Write(request);
  technique_.AwaitBegun(2);
  EXPECT_EQ(technique_.stopped(), 1u) << "not before the deadline";
  const auto stopped = technique_.AwaitStop(1);
  ASSERT_TRUE(stopped);
  EXPECT_LT(Ms(*stopped - (begun + deadline)), kPromptly);
  v1::SessionResponse response;
  while (stream->Read(&response)) {
  }
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
}

TEST_F(JobStopTest, AnotherWhoWantsTheSameKeepsItGoing) {
  auto other = client_->OpenSession("studio");
  ASSERT_EQ(other->Subscribe(1, FloorSpec(), 8), absl::OkStatus());
  session_->Cancel();
  EXPECT_TRUE(absl::IsCancelled(session_->End()));
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_EQ(technique_.stopped(), 0u);
  const auto since = Clock::now();
  other->Cancel();
  ExpectStop(since);
}

TEST_F(JobStopTest, C17WhatWaitsNeverRunsOnceNobodyWantsIt) {
  auto other = client_->OpenSession("studio");
  for (uint32_t id = 1; id <= 20; ++id) {
    ASSERT_EQ(other->Subscribe(id, FloorSpec(id), 8), absl::OkStatus());
  }
  const auto waiting = [&] {
    grpc::ClientContext context;
    v1::GetServerStatusResponse status;
    EXPECT_TRUE(client_->stub().GetServerStatus(&context, {}, &status).ok());
    return status.scenes(0).jobs_waiting();
  };
  // FloorSpec(16) is the one that runs.
  EXPECT_EQ(waiting(), 19u);
  other.reset();
  for (const auto end = Clock::now() + kPatience; waiting() > 0 && Clock::now() < end;) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_EQ(waiting(), 0u);
  session_->Cancel();
  ASSERT_TRUE(technique_.AwaitStop(0));
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_EQ(technique_.begun(), 1u);
}

}  // namespace
}  // namespace penumbra::testing
