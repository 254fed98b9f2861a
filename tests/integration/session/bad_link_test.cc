// A RemoteEngine over a line that is slow, thin, chops what it carries, breaks, or carries nothing
// any more: what comes is late, never wrong.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <random>
#include <thread>

#include "tests/integration/session/remote_engine_fixture.h"
#include "tests/support/fault_proxy.h"

namespace penumbra::testing {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

// A peer that vanished is found within twice this.
constexpr milliseconds kKeepalive{1'000};

class BadLinkTest : public RemoteEngineTest {
 protected:
  void SetUp() override {
    ServerLimits limits;
    limits.keepalive_interval = kKeepalive;
    limits.keepalive_timeout = kKeepalive;
    limits.least_ping_interval = kKeepalive / 4;
    auto server =
        PenumbraServer::Start({.listen = "127.0.0.1:0", .opens_gl = false, .limits = limits});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    link_ = std::make_unique<FaultProxy>(server_->address());
    near_ = Connect();
    ASSERT_EQ(near_->CreateScene("studio"), absl::OkStatus());
    ASSERT_TRUE(near_->Commit("studio", Studio()).ok());
  }

  std::unique_ptr<RemoteEngine> ConnectFar() {
    auto engine =
        RemoteEngine::Connect({.address = link_->address(),
                               .connect_timeout_s = 10,
                               .keepalive_s = std::chrono::duration<double>(kKeepalive).count(),
                               .reconnect_for_s = 20,
                               .on_connection = [this](const ConnectionEvent& event) {
                                 std::lock_guard lock(mutex_);
                                 events_.push_back(event);
                               }});
    EXPECT_TRUE(engine.ok()) << engine.status();
    return *std::move(engine);
  }

  bool AwaitEvent(ConnectionEvent::Kind kind, Clock::duration patience) {
    for (const auto end = Clock::now() + patience; Clock::now() < end;) {
      {
        std::lock_guard lock(mutex_);
        for (const ConnectionEvent& event : events_) {
          if (event.kind == kind) return true;
        }
      }
      std::this_thread::sleep_for(milliseconds(10));
    }
    return false;
  }

  void ExpectTheSame(RemoteEngine& far) {
    auto seen = far.Snapshot("studio"), is = near_->Snapshot("studio");
    // Each hears of the other's commits a little later than of its own.
    for (const auto end = Clock::now() + kPatience;
         seen.ok() && is.ok() && (*seen)->revision() != (*is)->revision() && Clock::now() < end;) {
      std::this_thread::sleep_for(milliseconds(10));
      seen = far.Snapshot("studio");
      is = near_->Snapshot("studio");
    }
    ASSERT_TRUE(seen.ok() && is.ok()) << seen.status() << is.status();
    EXPECT_EQ((*seen)->content_hash(), (*is)->content_hash());
    EXPECT_EQ((*seen)->revision(), (*is)->revision());
    const auto here = ComputeOnce(*near_, "studio", FloorSpec());
    const auto there = ComputeOnce(far, "studio", FloorSpec());
    ASSERT_TRUE(here.ok() && there.ok()) << here.status() << there.status();
    EXPECT_EQ(CountsOf(**there), CountsOf(**here));
  }

  // Commits until `is_over`; how many there were.
  static uint64_t CommitUntil(const std::atomic<bool>& is_over, RemoteEngine& engine) {
    uint64_t commits = 0;
    while (!is_over) {
      const auto revision =
          engine.Commit("studio", Studio(Vec3(0.001f * static_cast<float>(commits), 0.5f, 0)));
      EXPECT_TRUE(revision.ok()) << revision.status();
      if (!revision.ok()) break;
      ++commits;
    }
    return commits;
  }

  std::unique_ptr<FaultProxy> link_;
  std::unique_ptr<RemoteEngine> near_;  // past the link
  std::mutex mutex_;
  std::vector<ConnectionEvent> events_;
};

class SlowLinkTest : public BadLinkTest, public ::testing::WithParamInterface<LinkFaults> {};

TEST_P(SlowLinkTest, C23WhatComesIsLateNeverWrong) {
  link_->Set(GetParam());
  const auto far = ConnectFar();
  ExpectTheSame(*far);
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(far->Commit("studio", Studio(Vec3(0.1f * i, 0.5f, 0))).ok());
  }
  ASSERT_TRUE(near_->Commit("studio", Studio(Vec3(0, 0.5f, 0.3f))).ok());
  ASSERT_TRUE(far->Commit("studio", Studio(Vec3(0.2f, 0.5f, 0.3f))).ok());
  ExpectTheSame(*far);
  EXPECT_GT(link_->carried_bytes(), 5'000u);
  std::lock_guard lock(mutex_);
  EXPECT_TRUE(events_.empty()) << "a slow line is not a broken one: " << events_.front().reason;
}

INSTANTIATE_TEST_SUITE_P(All, SlowLinkTest,
                         ::testing::Values(LinkFaults{.latency = milliseconds(200)},
                                           LinkFaults{.bytes_per_second = 125'000},
                                           LinkFaults{.slice_bytes = 1},
                                           LinkFaults{.lost_share = 0.01},
                                           LinkFaults{.lost_share = 0.05},
                                           LinkFaults{.latency = milliseconds(20),
                                                      .bytes_per_second = 500'000,
                                                      .slice_bytes = 7}));

TEST_F(BadLinkTest, C23ConnectionsThatAreResetLoseNothing) {
  const auto far = ConnectFar();
  ASSERT_TRUE(far->Commit("studio", Studio()).ok());
  std::atomic<bool> is_over = false;
  auto writer = std::async(std::launch::async, [&] { return CommitUntil(is_over, *far); });
  std::minstd_rand random(7);
  for (int i = 0; i < 20; ++i) {
    std::this_thread::sleep_for(milliseconds(20 + random() % 100));
    link_->ResetAll();
  }
  is_over = true;
  const uint64_t commits = writer.get();
  EXPECT_GT(commits, 20u);
  EXPECT_TRUE(AwaitEvent(ConnectionEvent::Kind::kRestored, kPatience));
  ExpectTheSame(*far);
  EXPECT_EQ((*far->Snapshot("studio"))->revision(), commits + 2) << "each commit is one revision";
}

TEST_F(BadLinkTest, C18AServerThatVanishesIsFoundAndCommitsAreAppliedOnce) {
  const auto far = ConnectFar();
  ASSERT_TRUE(far->Commit("studio", Studio()).ok());
  // Longer than gRPC asks by itself on a line without data.
  std::this_thread::sleep_for(5 * kKeepalive);
  ASSERT_FALSE(AwaitEvent(ConnectionEvent::Kind::kLost, milliseconds(0))) << "it was there";
  link_->Set({.is_black_hole = true});
  auto commit = std::async(std::launch::async,
                           [&] { return far->Commit("studio", Studio(Vec3(0.3f, 0.5f, 0))); });
  EXPECT_TRUE(AwaitEvent(ConnectionEvent::Kind::kLost, 4 * kKeepalive));
  link_->ResetAll();
  link_->Set({});
  EXPECT_EQ(commit.get().value(), 3u);
  EXPECT_TRUE(AwaitEvent(ConnectionEvent::Kind::kRestored, kPatience));
  ExpectTheSame(*far);
}

TEST_F(BadLinkTest, C18AClientThatVanishesIsFound) {
  const auto far = ConnectFar();
  ASSERT_TRUE(far->Commit("studio", Studio()).ok());
  const auto sessions = [&] { return near_->ServerStatusJson().value(); };
  std::this_thread::sleep_for(5 * kKeepalive);
  EXPECT_THAT(sessions(), ::testing::HasSubstr("\"open_sessions\":\"2\""));
  link_->Set({.is_black_hole = true});
  const auto end = Clock::now() + 6 * kKeepalive;
  while (Clock::now() < end && sessions().find("\"open_sessions\":\"2\"") != std::string::npos) {
    std::this_thread::sleep_for(milliseconds(50));
  }
  EXPECT_THAT(sessions(), ::testing::HasSubstr("\"open_sessions\":\"1\""));
}

}  // namespace
}  // namespace penumbra::testing
