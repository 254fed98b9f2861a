// A RemoteEngine whose connections break, or whose server is started anew.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <future>
#include <thread>

#include "tests/integration/session/remote_engine_fixture.h"
#include "tests/support/temporary_folder.h"

namespace penumbra::testing {
namespace {

class ReconnectTest : public RemoteEngineTest {
 protected:
  void SetUp() override { StartOn("127.0.0.1:0"); }

  // With the scenes of the server before it.
  void StartOn(const std::string& listen) {
    auto server =
        PenumbraServer::Start({.listen = listen, .opens_gl = false, .data_dir = folder_ / "data"});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }
  void Restart() {
    const std::string address = server_->address();
    server_->Shutdown(std::chrono::seconds(2));
    server_.reset();
    StartOn(address);
  }
  std::unique_ptr<RemoteEngine> ConnectForLong() {
    auto engine = RemoteEngine::Connect({.address = server_->address(),
                                         .reconnect_for_s = 20,
                                         .on_connection = [this](const ConnectionEvent& event) {
                                           std::lock_guard lock(mutex_);
                                           events_.push_back(event);
                                         }});
    EXPECT_TRUE(engine.ok()) << engine.status();
    return *std::move(engine);
  }
  std::vector<ConnectionEvent> events() {
    std::lock_guard lock(mutex_);
    return events_;
  }

  const TemporaryFolder folder_;
  std::mutex mutex_;
  std::vector<ConnectionEvent> events_;
};

TEST_F(ReconnectTest, EverythingGoesOnAfterARestart) {
  const auto engine = ConnectForLong();
  ASSERT_EQ(engine->CreateScene("studio"), absl::OkStatus());
  ASSERT_TRUE(engine->Commit("studio", Studio()).ok());
  Inbox inbox;
  const auto subscription = engine->Subscribe("studio", FloorSpec(), inbox.callback());
  ASSERT_TRUE(subscription.ok());
  ASSERT_TRUE(inbox.WaitForFinal(1));
  for (int i = 0; i < 3; ++i) {
    Restart();
    const auto revision = engine->Commit("studio", Studio(Vec3(0.1f * i, 0.5f, 0)));
    ASSERT_EQ(revision.value(), 2u + i);
    EXPECT_TRUE(inbox.WaitForFinal(*revision)) << "the subscription goes on";
    EXPECT_EQ((*engine->Snapshot("studio"))->revision(), *revision);
  }
  const auto told = events();
  ASSERT_GE(told.size(), 6u);
  EXPECT_EQ(told[0].kind, ConnectionEvent::Kind::kLost);
  EXPECT_EQ(told[1].kind, ConnectionEvent::Kind::kRestored);
  EXPECT_TRUE(told[1].missed_nothing);
  EXPECT_GE(told[1].attempts, 1);
  for (const ArtifactUpdate& update : inbox.updates()) EXPECT_TRUE(update.status.ok());
}

TEST_F(ReconnectTest, B08CommitsUnderWayAreAppliedOnce) {
  const auto engine = ConnectForLong();
  ASSERT_EQ(engine->CreateScene("studio"), absl::OkStatus());
  ASSERT_TRUE(engine->Commit("studio", Studio()).ok());
  std::atomic<bool> is_over = false;
  std::vector<std::future<uint64_t>> writers;
  for (int writer = 0; writer < 4; ++writer) {
    writers.push_back(std::async(std::launch::async, [&, writer] {
      uint64_t commits = 0;
      while (!is_over) {
        const auto revision =
            engine->Commit("studio", Studio(Vec3(0.01f * writer, 0.5f, 0.0001f * commits)));
        EXPECT_TRUE(revision.ok()) << revision.status();
        commits += revision.ok();
      }
      return commits;
    }));
  }
  for (int i = 0; i < 5; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    Restart();
  }
  is_over = true;
  uint64_t commits = 1;
  for (auto& writer : writers) commits += writer.get();
  const auto mine = engine->Snapshot("studio");
  ASSERT_TRUE(mine.ok()) << mine.status();
  EXPECT_EQ((*mine)->revision(), commits) << "each commit is one revision";
  const auto other = Connect();
  EXPECT_EQ((*other->Snapshot("studio"))->content_hash(), (*mine)->content_hash());
}

TEST_F(ReconnectTest, WhatOthersDidMeanwhileIsHeard) {
  const auto engine = ConnectForLong();
  ASSERT_EQ(engine->CreateScene("studio"), absl::OkStatus());
  ASSERT_TRUE(engine->Commit("studio", Studio()).ok());
  Restart();
  const auto other = Connect();
  ASSERT_EQ(other->Commit("studio", Studio(Vec3(1, 0.5f, 0))).value(), 2u);
  EXPECT_EQ(engine->Commit("studio", Studio(Vec3(2, 0.5f, 0))).value(), 3u);
  // The other's mirror may not have heard of revision 3 yet; a newcomer's has.
  EXPECT_EQ((*engine->Snapshot("studio"))->content_hash(),
            (*Connect()->Snapshot("studio"))->content_hash());
}

TEST_F(ReconnectTest, ADeletedSceneIsGivenUp) {
  const auto engine = ConnectForLong();
  ASSERT_EQ(engine->CreateScene("studio"), absl::OkStatus());
  ASSERT_TRUE(engine->Commit("studio", Studio()).ok());
  Inbox inbox;
  const auto subscription = engine->Subscribe("studio", FloorSpec(), inbox.callback());
  ASSERT_TRUE(inbox.WaitForFinal(1));
  const std::string address = server_->address();
  server_->Shutdown(std::chrono::seconds(2));
  server_.reset();
  std::filesystem::remove_all(folder_ / "data");
  StartOn(address);
  EXPECT_TRUE(inbox.WaitForError(absl::StatusCode::kNotFound)) << inbox.updates().back().status;
  EXPECT_EQ(events().back().kind, ConnectionEvent::Kind::kGivenUp);
}

TEST_F(ReconnectTest, AnEngineThatWaitsForItsServerCanEnd) {
  auto engine = ConnectForLong();
  ASSERT_EQ(engine->CreateScene("studio"), absl::OkStatus());
  ASSERT_TRUE(engine->Commit("studio", Studio()).ok());
  server_.reset();
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  ASSERT_FALSE(events().empty()) << "it is trying";
  const auto start = std::chrono::steady_clock::now();
  engine.reset();
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
}

}  // namespace
}  // namespace penumbra::testing
