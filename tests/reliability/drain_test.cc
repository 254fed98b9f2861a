// Servers that are told to end and are started anew, twenty times, under clients that go on.

#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <future>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "client/session/remote_engine.h"
#include "render/engine/compute_once.h"
#include "render/engine/local_engine.h"
#include "render/scene/scene_difference.h"
#include "tests/support/daemon.h"
#include "tests/support/shapes.h"
#include "tests/support/temporary_folder.h"

namespace penumbra::testing {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kRestarts = 20;
constexpr int kWriters = 4;

SceneDelta Studio() {
  SceneDelta delta;
  delta.upsert_lights = {
      {.id = "lamp",
       .shape =
           RectangleLight{.corner = {-0.5f, 3, -0.5f}, .edge_u = {1, 0, 0}, .edge_v = {0, 0, 1}}}};
  delta.upsert_receivers = {FloorReceiver("floor", 4.0f, 128)};
  return delta;
}

SceneDelta Move(int writer, uint64_t turn) {
  static const auto box = MeshOf(UnitBoxGeometry());
  SceneDelta delta;
  delta.upsert_instances = {
      {.id = "box" + std::to_string(writer),
       .mesh = box,
       .world_from_mesh = Placed({0.5f * static_cast<float>(writer) - 1,
                                  0.5f + 0.001f * static_cast<float>(turn % 500), 0},
                                 0.2f)}};
  return delta;
}

const ArtifactSpec kSpec{SoftTextureParams{.samples = 16}, "lamp", "floor"};

class DrainTest : public ::testing::Test {
 protected:
  void Start(const std::string& listen) {
    daemon_ = std::make_unique<Daemon>(
        std::vector<std::string>{"--listen", listen, "--data-dir", folder_ / "data"});
    address_ = daemon_->Address();
    ASSERT_FALSE(address_.empty()) << daemon_->ErrorLine();
  }
  std::unique_ptr<RemoteEngine> Connect() {
    auto engine = RemoteEngine::Connect({.address = address_, .reconnect_for_s = 60});
    EXPECT_TRUE(engine.ok()) << engine.status();
    return *std::move(engine);
  }

  // How many commits there were.
  uint64_t CommitUntil(const std::atomic<bool>& is_over, int writer) {
    const auto engine = Connect();
    uint64_t commits = 0;
    while (!is_over) {
      const auto revision = engine->Commit("studio", Move(writer, commits));
      EXPECT_TRUE(revision.ok()) << revision.status();
      if (!revision.ok()) break;
      ++commits;
    }
    return commits;
  }

  // How long the slowest end took, in seconds.
  double RestartAllTheTime() {
    double slowest_s = 0;
    for (int i = 0; i < kRestarts; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(300));
      const auto told = Clock::now();
      daemon_->Signal(SIGTERM);
      EXPECT_EQ(daemon_->Wait(), 0);
      slowest_s = std::max(slowest_s, std::chrono::duration<double>(Clock::now() - told).count());
      Start(address_);
    }
    return slowest_s;
  }

  // Every commit, and a shadow that is what anybody computes of the scene.
  static void ExpectAllThere(RemoteEngine& watcher, uint64_t commits) {
    const auto scene = watcher.Snapshot("studio");
    ASSERT_TRUE(scene.ok()) << scene.status();
    EXPECT_EQ((*scene)->revision(), commits) << "each commit is one revision";
    LocalEngine offline;
    ASSERT_EQ(offline.CreateScene("studio"), absl::OkStatus());
    ASSERT_TRUE(offline.Commit("studio", Difference(*Scene::Empty("studio"), **scene)).ok());
    const auto here = ComputeOnce(offline, "studio", kSpec),
               there = ComputeOnce(watcher, "studio", kSpec);
    ASSERT_TRUE(here.ok() && there.ok()) << here.status() << there.status();
    EXPECT_EQ(std::get<SoftShadowTexture>((*here)->payload).visibility.counts,
              std::get<SoftShadowTexture>((*there)->payload).visibility.counts);
  }

  const TemporaryFolder folder_;
  std::unique_ptr<Daemon> daemon_;
  std::string address_;
};

TEST_F(DrainTest, C25TwentySigtermsUnderLoadFailNoCommitAndLoseNone) {
  Start("127.0.0.1:0");
  const auto watcher = Connect();
  ASSERT_EQ(watcher->CreateScene("studio"), absl::OkStatus());
  ASSERT_EQ(watcher->Commit("studio", Studio()).value(), 1u);
  std::atomic<uint64_t> errors = 0, updates = 0;
  const auto subscription = watcher->Subscribe("studio", kSpec, [&](const ArtifactUpdate& update) {
    errors += !update.status.ok();
    ++updates;
  });
  ASSERT_TRUE(subscription.ok()) << subscription.status();
  std::atomic<bool> is_over = false;
  std::vector<std::future<uint64_t>> writers;
  for (int writer = 0; writer < kWriters; ++writer) {
    writers.push_back(
        std::async(std::launch::async, [&, writer] { return CommitUntil(is_over, writer); }));
  }
  const double slowest_s = RestartAllTheTime();
  is_over = true;
  uint64_t commits = 1;
  for (auto& writer : writers) commits += writer.get();
  EXPECT_LT(slowest_s, 10);
  EXPECT_EQ(errors, 0u);
  ExpectAllThere(*watcher, commits);
  std::printf("drained: %d times, %llu commits, %llu updates, slowest end %.2f s\n", kRestarts,
              static_cast<unsigned long long>(commits), static_cast<unsigned long long>(updates),
              slowest_s);
}

}  // namespace
}  // namespace penumbra::testing
