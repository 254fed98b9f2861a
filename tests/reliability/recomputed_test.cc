// Sixteen clients edit one scene and watch its shadow: what they get is what anybody would compute
// from the revision that it names, bit for bit.

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <map>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "client/session/remote_engine.h"
#include "render/engine/compute_once.h"
#include "render/engine/local_engine.h"
#include "tests/support/daemon.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

constexpr int kClients = 16;
constexpr double kEditsPerSecond = 50;  // of all together
constexpr double kSeconds = 30;
constexpr size_t kSamples = 200;

Instance BoxOf(int client, int turn) {
  static const auto box = MeshOf(UnitBoxGeometry());
  const Vec3 place(0.4f * static_cast<float>(client % 4) - 0.6f,
                   0.4f + 0.01f * static_cast<float>(turn % 50),
                   0.4f * static_cast<float>(client / 4) - 0.6f);
  return {
      .id = "box" + std::to_string(client), .mesh = box, .world_from_mesh = Placed(place, 0.1f)};
}

SceneDelta Studio() {
  SceneDelta delta;
  for (int client = 0; client < kClients; ++client) {
    delta.upsert_instances.push_back(BoxOf(client, 0));
  }
  delta.upsert_lights = {
      {.id = "lamp",
       .shape =
           RectangleLight{.corner = {-0.5f, 3, -0.5f}, .edge_u = {1, 0, 0}, .edge_v = {0, 0, 1}}}};
  delta.upsert_receivers = {FloorReceiver("floor", 4.0f, 256)};
  return delta;
}

const ArtifactSpec kSpec{SoftTextureParams{.samples = 64}, "lamp", "floor"};

const std::vector<uint16_t>& CountsOf(const Artifact& artifact) {
  return std::get<SoftShadowTexture>(artifact.payload).visibility.counts;
}

class RecomputedTest : public ::testing::Test {
 protected:
  void SetUp() override {
    address_ = daemon_.Address();
    for (int client = 0; client < kClients; ++client) {
      auto engine = RemoteEngine::Connect({.address = address_});
      ASSERT_TRUE(engine.ok()) << engine.status();
      engines_.push_back(*std::move(engine));
    }
    ASSERT_EQ(engines_[0]->CreateScene("studio"), absl::OkStatus());
    Note(engines_[0]->Commit("studio", Studio()), Studio());
  }

  void Note(const absl::StatusOr<Revision>& revision, const SceneDelta& delta) {
    ASSERT_TRUE(revision.ok()) << revision.status();
    std::lock_guard lock(mutex_);
    EXPECT_TRUE(commits_.emplace(*revision, delta).second) << "two commits of one revision";
  }

  void Edit(int client) {
    const auto start = std::chrono::steady_clock::now();
    for (int turn = 1; turn < kSeconds * kEditsPerSecond / kClients; ++turn) {
      const std::chrono::duration<double> due((turn + double{1} * client / kClients) * kClients /
                                              kEditsPerSecond);
      std::this_thread::sleep_until(
          start + std::chrono::duration_cast<std::chrono::steady_clock::duration>(due));
      SceneDelta delta;
      delta.upsert_instances = {BoxOf(client, turn)};
      Note(engines_[static_cast<size_t>(client)]->Commit("studio", delta), delta);
    }
  }

  void Keep(const ArtifactUpdate& update) {
    ++updates_;
    if (!update.artifact || !update.artifact->header.is_final) return;
    std::lock_guard lock(mutex_);
    kept_[update.artifact->header.revision].push_back(update.artifact);
  }

  // Every so many revisions of those that somebody got.
  size_t CompareWithRecomputed() {
    LocalEngine offline;
    EXPECT_EQ(offline.CreateScene("studio"), absl::OkStatus());
    const size_t stride = std::max<size_t>(1, kept_.size() / kSamples);
    size_t compared = 0, index = 0;
    for (const auto& [revision, delta] : commits_) {
      EXPECT_EQ(offline.Commit("studio", delta).value(), revision);
      const auto kept = kept_.find(revision);
      if (kept == kept_.end() || index++ % stride != 0) continue;
      const auto again = ComputeOnce(offline, "studio", kSpec);
      EXPECT_TRUE(again.ok()) << again.status();
      for (const auto& artifact : kept->second) {
        EXPECT_EQ(artifact->header.scene_hash, (*again)->header.scene_hash);
        EXPECT_EQ(CountsOf(*artifact), CountsOf(**again)) << "revision " << revision;
        ++compared;
      }
    }
    return compared;
  }

  Daemon daemon_{{"--listen", "127.0.0.1:0"}};
  std::string address_;
  std::mutex mutex_;
  std::map<Revision, SceneDelta> commits_;
  std::map<Revision, std::vector<std::shared_ptr<const Artifact>>> kept_;
  std::atomic<uint64_t> updates_ = 0;
  std::vector<std::unique_ptr<RemoteEngine>> engines_;
};

TEST_F(RecomputedTest, ArtifactsAreThoseOfTheRevisionThatTheyName) {
  std::vector<std::unique_ptr<Subscription>> subscriptions;
  for (const auto& engine : engines_) {
    auto subscription =
        engine->Subscribe("studio", kSpec, [this](const ArtifactUpdate& update) { Keep(update); });
    ASSERT_TRUE(subscription.ok()) << subscription.status();
    subscriptions.push_back(*std::move(subscription));
  }
  std::vector<std::jthread> editors;
  for (int client = 0; client < kClients; ++client) {
    editors.emplace_back([this, client] { Edit(client); });
  }
  editors.clear();
  subscriptions.clear();
  const size_t compared = CompareWithRecomputed();
  std::printf("recomputed: %zu commits, %llu updates, artifacts of %zu revisions, %zu compared\n",
              commits_.size(), static_cast<unsigned long long>(updates_), kept_.size(), compared);
  EXPECT_GE(compared, 100u);
}

}  // namespace
}  // namespace penumbra::testing
