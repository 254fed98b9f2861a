// A disk or a processor that does not keep up: commits that would wait for too long, or too many of
// them, are refused at once, with a time to come back; those that were let in are kept.

#include <gtest/gtest.h>

#include <chrono>
#include <map>
#include <string>
#include <thread>

#include "client/session/remote_engine.h"
#include "proto/convert/scene_convert.h"
#include "render/scene/field_error.h"
#include "render/scene/retry_delay.h"
#include "tests/integration/service/durable_scenes.h"
#include "tests/integration/service/unconnected_session.h"
#include "tests/support/faulty_vfs.h"
#include "tests/support/held_threads.h"
#include "tests/support/http_get.h"

namespace penumbra::testing {
namespace {

using Clock = std::chrono::steady_clock;
using Ms = std::chrono::duration<double, std::milli>;

// The bar that refusals are held to, with something for machines that build beside the test.
constexpr Ms kAtOnce{200};

class OverloadTest : public DurableScenesTest {
 protected:
  OverloadTest() { options_.storage.database.vfs = disk_.name(); }
  ~OverloadTest() override {
    disk_.Heal();
    session_.reset();
    client_.reset();
    server_.reset();  // before the disk that it writes to
  }

  void SendCommit(uint64_t id, const SceneDelta& delta, const std::string& key = {}) {
    v1::SessionRequest request;
    request.mutable_commit()->set_commit_id(id);
    request.mutable_commit()->set_idempotency_key(key);
    *request.mutable_commit()->mutable_delta() = ToProto(delta);
    session_->Send(request);
  }
  v1::CommitResult NextResult() {
    const auto response = session_->ReadUntil(v1::SessionResponse::kCommitResult);
    return response ? response->commit_result() : v1::CommitResult();
  }
  static void ExpectRefusal(const v1::CommitResult& result, const std::string& reason) {
    const absl::Status error = ErrorIn(result);
    EXPECT_EQ(error.code(), absl::StatusCode::kResourceExhausted) << error;
    EXPECT_EQ(ErrorReason(error), reason) << error;
    EXPECT_EQ(ErrorFieldPath(error), "commit");
    EXPECT_GE(RetryDelayMs(error).value_or(-1), 50) << error;
    EXPECT_LE(RetryDelayMs(error).value_or(1e9), 5'000) << error;
  }

  FaultyVfs disk_;
};

// Row C14, and the retry delay of row C19.
TEST_F(OverloadTest, WhatWouldWaitForLongIsRefusedAtOnceAndBeforeWhatWaits) {
  options_.limits.max_commit_delay_ms = 100;
  Restart();
  MakeStudio();
  disk_.Stall();
  SendCommit(100, MoveBox({1, 1, 0}));
  SendCommit(101, MoveBox({2, 1, 0}));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  const auto asked = Clock::now();
  SendCommit(102, MoveBox({3, 1, 0}));
  const auto refused = NextResult();
  EXPECT_LT(Ms(Clock::now() - asked), kAtOnce);
  EXPECT_EQ(refused.commit_id(), 102u) << "the answers to the others wait for the disk";
  EXPECT_EQ(refused.revision(), 1u) << "nothing has changed yet";
  ExpectRefusal(refused, "OVERLOADED");
  EXPECT_GE(RetryDelayMs(ErrorIn(refused)).value(), 200) << "as long as it is behind";
  disk_.Heal();
  EXPECT_EQ(NextResult().revision(), 2u);
  EXPECT_EQ(NextResult().revision(), 3u);
  EXPECT_EQ(session_->Commit(MoveBox({3, 1, 0})).revision(), 4u) << "and all is as before";
}

TEST_F(OverloadTest, CommitsOnTheirWayAreBoundedInNumber) {
  options_.limits.max_pending_commits = 5;
  options_.limits.max_commit_delay_ms = 60'000;
  Restart();
  MakeStudio();
  disk_.Stall();
  for (uint64_t id = 100; id < 108; ++id) SendCommit(id, MoveBox({0.1f * (id - 100), 1, 0}));
  for (uint64_t id = 105; id < 108; ++id) {
    const auto refused = NextResult();
    EXPECT_EQ(refused.commit_id(), id);
    ExpectRefusal(refused, "QUOTA_PENDING");
  }
  disk_.Heal();
  for (uint64_t id = 100; id < 105; ++id) EXPECT_EQ(NextResult().revision(), id - 100 + 2);
  EXPECT_EQ(client_->FindScene("studio")->revision, 6u);
}

TEST_F(OverloadTest, AndInBytesOfASceneAndOfAll) {
  const uint64_t bytes = ToProto(MoveBox({1, 1, 0})).ByteSizeLong();
  options_.limits.max_pending_commit_bytes = 3 * bytes;
  options_.limits.max_all_pending_commit_bytes = 10 * bytes;  // half of it is one principal's
  options_.limits.max_commit_delay_ms = 60'000;
  Restart();
  MakeStudio("other");
  auto other = std::move(session_);
  ASSERT_EQ(client_->CreateScene("studio"), absl::OkStatus());
  session_ = client_->OpenSession("studio");
  // Not larger than those that move it.
  for (const char* id : {"a", "b"}) {
    ASSERT_FALSE(
        session_->Commit(SceneDelta{.upsert_instances = {Box({0, 1, 0}, id)}}).has_error());
  }
  disk_.Stall();
  for (uint64_t id = 100; id < 104; ++id) SendCommit(id, MoveBox({1, 1, 0}));
  const auto of_scene = NextResult();
  EXPECT_EQ(of_scene.commit_id(), 103u);
  ExpectRefusal(of_scene, "QUOTA_PENDING_BYTES");
  EXPECT_NE(of_scene.error().message().find("of one scene"), std::string::npos);
  std::swap(session_, other);
  for (uint64_t id = 200; id < 203; ++id) SendCommit(id, MoveBox({1, 1, 0}));
  const auto of_all = NextResult();
  EXPECT_EQ(of_all.commit_id(), 202u);
  ExpectRefusal(of_all, "QUOTA_PENDING_BYTES");
  EXPECT_NE(of_all.error().message().find("of all scenes"), std::string::npos);
  disk_.Heal();
  EXPECT_EQ(NextResult().revision(), 2u);
  EXPECT_EQ(NextResult().revision(), 3u);
  EXPECT_EQ(session_->Commit(MoveBox({2, 1, 0})).revision(), 4u)
      << "what is written counts no longer";
}

// Its client has lost the connection, say, and cannot know that it waits.
TEST_F(OverloadTest, ACommitThatIsSentAgainWhileItWaitsIsAppliedOnce) {
  options_.limits.max_commit_delay_ms = 60'000;
  Restart();
  MakeStudio();
  disk_.Stall();
  SendCommit(100, MoveBox({1, 1, 0}), "key");
  SendCommit(101, MoveBox({1, 1, 0}), "key");
  SendCommit(102, MoveBox({2, 1, 0}), "key");
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  disk_.Heal();
  EXPECT_EQ(NextResult().revision(), 2u);
  EXPECT_EQ(NextResult().revision(), 2u);
  EXPECT_EQ(ErrorReason(ErrorIn(NextResult())), "REQUEST_ID_REUSED");
  EXPECT_EQ(client_->FindScene("studio")->revision, 2u);
}

// The client library waits as long as it was told, and then sends the commit again.
TEST_F(OverloadTest, TheLibrarysCommitsComeThroughOnce) {
  options_.limits.max_commit_delay_ms = 100;
  Restart();
  MakeStudio();
  auto engine = RemoteEngine::Connect({.address = server_->address()});
  ASSERT_TRUE(engine.ok()) << engine.status();
  ASSERT_TRUE((*engine)->Snapshot("studio").ok());
  disk_.Stall();
  SendCommit(100, MoveBox({1, 1, 0}));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  std::thread release([this] {
    std::this_thread::sleep_for(std::chrono::milliseconds(400));
    disk_.Heal();
  });
  const auto asked = Clock::now();
  const auto revision = (*engine)->Commit("studio", MoveBox({2, 1, 0}));
  EXPECT_GE(Ms(Clock::now() - asked).count(), 200) << "it was told to wait";
  release.join();
  ASSERT_TRUE(revision.ok()) << revision.status();
  EXPECT_EQ(*revision, 3u);
  EXPECT_EQ(client_->FindScene("studio")->revision, 3u);
}

TEST_F(OverloadTest, RefusalsAreCountedByTheirReason) {
  options_.limits.max_commit_delay_ms = 100;
  options_.metrics_listen = "127.0.0.1:0";
  Restart();
  MakeStudio();
  disk_.Stall();
  SendCommit(100, MoveBox({1, 1, 0}));
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  SendCommit(101, MoveBox({1, 1, 0}));
  ExpectRefusal(NextResult(), "OVERLOADED");
  const auto logged = logger_.Await("refused", 1)[0];
  EXPECT_EQ(logged["reason"], "OVERLOADED");
  EXPECT_EQ(logged["field"], "commit");
  const std::string metrics = HttpGet(server_->metrics_address(), "/metrics");
  EXPECT_NE(metrics.find("penumbra_failures_total{reason=\"OVERLOADED\"} 1"), std::string::npos);
  EXPECT_NE(metrics.find("penumbra_read_delay_seconds 0\n"), std::string::npos);
  disk_.Heal();
  EXPECT_EQ(NextResult().revision(), 2u);
}

class BusyProcessorTest : public ::testing::Test {
 protected:
  BusyProcessorTest() {
    parts_.Hello("ana");
    while (parts_.Next()) {
    }
  }
  void Commit(int times, const std::string& key = {}) {
    for (int i = 0; i < times; ++i) {
      v1::SessionRequest request;
      request.mutable_commit()->set_commit_id(sent_++);
      request.mutable_commit()->set_idempotency_key(key);
      request.mutable_commit()->mutable_delta();  // of nothing
      parts_.Send(request);
    }
    while (const auto response = parts_.Next()) {
      if (!response->has_commit_result()) continue;
      answers_[response->commit_result().commit_id()] = ErrorIn(response->commit_result());
    }
  }

  UnconnectedSession parts_;
  uint64_t sent_ = 0;
  std::map<uint64_t, absl::Status> answers_;
};

TEST_F(BusyProcessorTest, WhileRequestsWaitToBeReadCommitsAreRefused) {
  HeldThreads held;
  Commit(32);  // so many at once that the server asks whether it keeps up
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  Commit(32);
  ASSERT_EQ(answers_.size(), 64u);
  int refused = 0;
  for (const auto& [id, error] : answers_) {
    EXPECT_TRUE(error.ok() || id >= 16) << error;
    if (error.ok()) continue;
    EXPECT_EQ(ErrorReason(error), "OVERLOADED") << error;
    EXPECT_GE(RetryDelayMs(error).value_or(0), 200) << error;
    refused += id >= 32;
  }
  EXPECT_GE(refused, 28);
  held.LetGo();
  std::this_thread::sleep_for(std::chrono::milliseconds(1'500));
  Commit(1);
  EXPECT_EQ(answers_[64], absl::OkStatus()) << "and all is as before";
}

// Row C21.
TEST_F(BusyProcessorTest, AndOfThoseWhoSendLittleFew) {
  const int another = 0;
  for (int i = 0; i < 20'000; ++i) parts_.processor().shares().OnRequest("another", &another);
  HeldThreads held;
  for (int i = 0; i < 20'000; ++i) parts_.processor().shares().OnRequest("another", &another);
  Commit(32);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  Commit(32);
  ASSERT_EQ(answers_.size(), 64u);
  int refused = 0;
  for (const auto& [id, error] : answers_) refused += !error.ok();
  EXPECT_LE(refused, 4);
}

// What has come through already: "refused" would say that it has not.
TEST_F(BusyProcessorTest, ACommitThatIsSentAgainIsAnsweredAsItWas) {
  Commit(1, "key");
  ASSERT_EQ(answers_[0], absl::OkStatus());
  HeldThreads held;
  Commit(32);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  Commit(32, "key");
  for (uint64_t id = 33; id < 65; ++id) EXPECT_EQ(answers_[id], absl::OkStatus()) << id;
}

// Row C20.
TEST(SessionQuotaTest, OneTooManyIsToldWhenToComeBack) {
  ServerOptions options;
  options.limits.max_sessions = 1;
  const auto server = StartServer(options);
  WireClient client(server->address());
  ASSERT_EQ(client.CreateScene("studio"), absl::OkStatus());
  const auto first = client.OpenSession("studio");
  WireSession second(client.stub());
  const absl::Status end = second.End();
  EXPECT_EQ(ErrorReason(end), "QUOTA_SESSIONS") << end;
  EXPECT_EQ(RetryDelayMs(end).value_or(0), 1'000);
}

}  // namespace
}  // namespace penumbra::testing
