// A server that is killed at random moments under load, again and again: whatever it acknowledged
// is there when it is back, and it is back soon. Row D01 of the catalogue.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <map>
#include <mutex>
#include <random>
#include <thread>
#include <vector>

#include "proto/convert/scene_convert.h"
#include "proto/convert/status_convert.h"
#include "render/scene/retry_delay.h"
#include "tests/integration/service/studio.h"
#include "tests/support/daemon.h"
#include "tests/support/temporary_folder.h"

namespace penumbra::testing {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kLives = 200;
constexpr int kScenes = 4;
constexpr int kClientsPerScene = 2;

struct Acknowledged {
  Revision revision = 0;
  std::string hash;
};

std::string SceneId(int scene) { return "scene" + std::to_string(scene); }

class KillTest : public ::testing::Test {
 protected:
  void MakeScenes(WireClient& client) {
    ASSERT_EQ(client.Upload(*BoxMesh()), absl::OkStatus());
    for (int scene = 0; scene < kScenes; ++scene) {
      ASSERT_EQ(client.CreateScene(SceneId(scene)), absl::OkStatus());
    }
  }

  // Commits until there is no answer.
  void Edit(WireClient& client, int scene, int writer, int life) {
    WireSession session(client.stub());
    v1::SessionRequest hello;
    hello.mutable_hello()->add_protocol_versions(1);
    hello.mutable_hello()->set_scene_id(SceneId(scene));
    session.Send(hello);
    const auto welcome = session.Read();
    if (!welcome) return;
    {
      std::lock_guard lock(mutex_);
      incarnations_[scene] = welcome->welcome().incarnation();
    }
    for (int i = 0;; ++i) {
      SceneDelta delta;
      delta.upsert_instances = {Box({0.001f * i, 1, 0.01f * life}, "box" + std::to_string(writer))};
      v1::SessionRequest request;
      *request.mutable_commit()->mutable_delta() = ToProto(delta);
      session.Send(request);
      const auto response = session.Read();
      if (!response) return;
      const v1::CommitResult& result = response->commit_result();
      if (const auto delay_ms = RetryDelayMs(FromProto(result.error()))) {
        std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(*delay_ms));
        continue;
      }
      EXPECT_FALSE(result.has_error()) << result.error().message();
      std::lock_guard lock(mutex_);
      acknowledged_[scene].push_back({result.revision(), result.content_hash()});
    }
  }

  // Whether the scene, as it is now, has had this revision with this content. Its history says so:
  // it is what a session resumes from.
  static bool HasHad(WireClient& client, int scene, const std::string& incarnation,
                     const Acknowledged& acknowledged) {
    WireSession session(client.stub());
    v1::SessionRequest request;
    v1::Hello& hello = *request.mutable_hello();
    hello.add_protocol_versions(1);
    hello.set_scene_id(SceneId(scene));
    hello.set_mirror_scene(true);
    hello.mutable_resume()->set_incarnation(incarnation);
    hello.mutable_resume()->set_revision(acknowledged.revision);
    hello.mutable_resume()->set_content_hash(acknowledged.hash);
    session.Send(request);
    const auto welcome = session.ReadUntil(v1::SessionResponse::kWelcome);
    return welcome && welcome->welcome().is_resumed();
  }

  // What was acknowledged in the last life: the newest and two others.
  void ExpectNothingLost(WireClient& client, int life) {
    for (auto& [scene, list] : acknowledged_) {
      if (list.empty()) continue;
      std::sort(list.begin(), list.end(),
                [](const auto& a, const auto& b) { return a.revision < b.revision; });
      const auto twice =
          std::adjacent_find(list.begin(), list.end(),
                             [](const auto& a, const auto& b) { return a.revision == b.revision; });
      EXPECT_EQ(twice, list.end()) << "two commits of one revision";
      const Revision head = client.FindScene(SceneId(scene)).value().revision;
      EXPECT_GE(head, list.back().revision) << "life " << life;
      EXPECT_LE(head, list.back().revision + kClientsPerScene) << "one of each may be on its way";
      for (const size_t i : {list.size() - 1, list.size() / 2, random_() % list.size()}) {
        EXPECT_TRUE(HasHad(client, scene, incarnations_[scene], list[i]))
            << "life " << life << ", revision " << list[i].revision << " of " << head;
      }
      commits_ += list.size();
      list.clear();
    }
  }

  const TemporaryFolder folder_;
  std::mt19937 random_{11};
  std::mutex mutex_;
  std::map<int, std::string> incarnations_;
  std::map<int, std::vector<Acknowledged>> acknowledged_;
  size_t commits_ = 0;
};

TEST_F(KillTest, D01NothingThatWasAcknowledgedIsLost) {
  double slowest_start_s = 0;
  for (int life = 0; life <= kLives; ++life) {
    const auto start = Clock::now();
    Daemon daemon({"--listen", "127.0.0.1:0", "--data-dir", folder_ / "data"});
    WireClient client(daemon.Address());
    ASSERT_TRUE(client.ListScenes().ok());
    slowest_start_s =
        std::max(slowest_start_s, std::chrono::duration<double>(Clock::now() - start).count());
    if (life == 0) MakeScenes(client);
    ExpectNothingLost(client, life);
    if (life == kLives) break;
    std::vector<std::thread> editors;
    for (int scene = 0; scene < kScenes; ++scene) {
      for (int writer = 0; writer < kClientsPerScene; ++writer) {
        editors.emplace_back([&, scene, writer] { Edit(client, scene, writer, life); });
      }
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(random_() % 250));
    daemon.Signal(SIGKILL);
    for (std::thread& editor : editors) editor.join();
  }
  std::printf("kills %d\ncommits %zu\nslowest_start_s %.2f\n", kLives, commits_, slowest_start_s);
  EXPECT_GT(commits_, 1'000u);
  EXPECT_LE(slowest_start_s, 2.0);
}

}  // namespace
}  // namespace penumbra::testing
