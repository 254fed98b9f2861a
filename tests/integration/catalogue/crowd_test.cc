// Rows C19 and C20: more clients, scenes and connections than anybody needs.

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <iostream>
#include <string>
#include <thread>
#include <vector>

#include "grpcpp/channel.h"
#include "tests/integration/catalogue/catalogue_test.h"

namespace penumbra::testing {
namespace {

using std::chrono::milliseconds, std::chrono::seconds, std::chrono::steady_clock;

constexpr auto kExhausted = absl::StatusCode::kResourceExhausted;

// Runs `visit(i)` for each i below `count`, on some threads.
void OnManyThreads(int count, const std::function<void(int)>& visit) {
  constexpr int kThreads = 25;
  std::atomic<int> next = 0;
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&] {
      for (int i = next++; i < count; i = next++) visit(i);
    });
  }
  for (std::thread& thread : threads) thread.join();
}

class CrowdTest : public CatalogueTest {
 protected:
  // Both ends of each connection are in this process, and a server takes half of what there may be.
  CrowdTest() {
    rlimit limit{};
    getrlimit(RLIMIT_NOFILE, &limit);
    limit.rlim_cur = std::min<rlim_t>(limit.rlim_max, 8'192);
    setrlimit(RLIMIT_NOFILE, &limit);
  }

  // That a session mirrors the scene as it is.
  static void ExpectMirrored(WireSession& session, const SceneInfo& scene) {
    Mirror mirror;
    while (mirror.revision < scene.revision) {
      const auto update = session.ReadUntil(v1::SessionResponse::kSceneUpdate);
      ASSERT_TRUE(update);
      mirror.Apply(update->scene_update());
    }
    EXPECT_EQ(mirror.scene->content_hash(), scene.content_hash);
  }
  bool ComeToBeOpen(uint64_t sessions) {
    for (const auto end = steady_clock::now() + kPatience; steady_clock::now() < end;) {
      if (client_->ServerInfo().statistics().open_sessions() == sessions) return true;
      std::this_thread::sleep_for(milliseconds(10));
    }
    return false;
  }
};

// Calls again and again, and keeps the longest that one took.
class SlowestCall {
 public:
  explicit SlowestCall(WireClient& client)
      : thread_([this, &client] {
          while (!is_over_) {
            const auto start = steady_clock::now();
            EXPECT_TRUE(client.FindScene("studio").ok());
            slowest_ = std::max(slowest_, steady_clock::now() - start);
            std::this_thread::sleep_for(milliseconds(20));
          }
        }) {}
  std::chrono::nanoseconds Time() {
    is_over_ = true;
    thread_.join();
    return slowest_;
  }

 private:
  std::atomic<bool> is_over_ = false;
  std::chrono::nanoseconds slowest_{0};
  std::thread thread_;
};

int64_t Milliseconds(std::chrono::nanoseconds time) {
  return std::chrono::duration_cast<milliseconds>(time).count();
}

// All come at once, as after a server's restart, each with a connection and a snapshot of its own.
TEST_F(CrowdTest, C19FiveHundredClientsThatComeBackAtOnceAreAllServed) {
  constexpr int kClients = 500;
  SceneDelta many;
  for (int i = 0; i < 1'000; ++i) {
    many.upsert_instances.push_back(Box({0, 1, 0.001f * i}, "box" + std::to_string(i)));
  }
  ASSERT_FALSE(session_->Commit(many).has_error());
  const SceneInfo scene = client_->FindScene("studio").value();

  std::vector<std::unique_ptr<WireClient>> clients(kClients);
  std::vector<std::unique_ptr<WireSession>> sessions(kClients);
  SlowestCall beside(*client_);
  const auto start = steady_clock::now();
  OnManyThreads(kClients, [&](int i) {
    clients[i] = std::make_unique<WireClient>(server_->address());
    sessions[i] = clients[i]->OpenSession("studio", /*mirror_scene=*/true);
    ExpectMirrored(*sessions[i], scene);
  });
  const auto took = steady_clock::now() - start;
  const auto slowest = beside.Time();
  std::cout << kClients << " clients in " << Milliseconds(took) << " ms; a call beside them took "
            << Milliseconds(slowest) << " ms at most\n";
  EXPECT_LT(slowest, seconds(5));
  EXPECT_TRUE(ComeToBeOpen(kClients + 2));
  OnManyThreads(kClients, [&](int i) { sessions[i].reset(); });
  EXPECT_TRUE(ComeToBeOpen(2));
}

TEST_F(CrowdTest, C20TenThousandScenesAreNotMade) {
  constexpr int kCreates = 10'000;
  const auto limit = client_->ServerInfo().limits().max_scenes();
  std::atomic<uint32_t> made = 0, refused = 0;
  OnManyThreads(kCreates, [&](int i) {
    const absl::Status status = client_->CreateScene("scene" + std::to_string(i));
    made += status.ok();
    refused += status.code() == kExhausted && ErrorReason(status) == "QUOTA_SCENES";
  });
  EXPECT_EQ(made, limit - 1) << "the studio is one";
  EXPECT_EQ(made + refused, uint32_t{kCreates});
  ExpectRefused([&] { return client_->CreateScene("one-more"); },
                {kExhausted, "QUOTA_SCENES", "scene_id"});
}

class FewSessionsTest : public CrowdTest {
 protected:
  FewSessionsTest() {
    options_.limits.max_sessions = 4;
    options_.limits.max_subscriptions_per_session = 3;
    options_.limits.connection_idle_timeout = milliseconds(500);
  }
};

TEST_F(FewSessionsTest, C20SessionsAndSubscriptionsHaveTheirNumber) {
  auto third = client_->OpenSession("studio");
  auto fourth = client_->OpenSession("studio");
  ExpectRefused(
      [&] {
        WireSession fifth(client_->stub());
        return fifth.End();
      },
      {kExhausted, "QUOTA_SESSIONS", ""});
  third.reset();
  EXPECT_TRUE(ComeToBeOpen(3));
  EXPECT_EQ(client_->OpenSession("studio")->Commit(SceneDelta()).revision(), 2u) << "there is room";
  for (uint64_t id = 1; id <= 3; ++id) {
    ASSERT_EQ(fourth->Subscribe(id, FloorSpec(static_cast<uint32_t>(id)), 1), absl::OkStatus());
  }
  ExpectRefused([&] { return fourth->Subscribe(4, FloorSpec(4), 1); },
                {kExhausted, "QUOTA_SUBSCRIPTIONS", "subscription_id"});
}

// A connection without a call is closed; the next call opens another.
TEST_F(FewSessionsTest, C20IdleConnectionsAreClosed) {
  WireClient idle(server_->address());
  EXPECT_EQ(idle.ServerInfo().limits().max_sessions(), 4u);
  const auto end = steady_clock::now() + kPatience;
  while (idle.channel()->GetState(/*try_to_connect=*/false) == GRPC_CHANNEL_READY &&
         steady_clock::now() < end) {
    std::this_thread::sleep_for(milliseconds(20));
  }
  EXPECT_NE(idle.channel()->GetState(false), GRPC_CHANNEL_READY);
  EXPECT_EQ(idle.ServerInfo().limits().max_sessions(), 4u);
}

}  // namespace
}  // namespace penumbra::testing
