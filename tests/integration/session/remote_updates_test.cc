// What subscribers of a RemoteEngine receive, and when.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "client/session/steady_clock.h"
#include "render/scene/field_error.h"
#include "tests/integration/session/remote_engine_fixture.h"

namespace penumbra::testing {
namespace {

using std::chrono::seconds;
using ::testing::HasSubstr;

TEST_F(RemoteEngineTest, ComputesWhatALocalEngineComputesBitForBit) {
  LocalEngine local;
  const auto remote = Connect();
  std::vector<std::shared_ptr<const Artifact>> artifacts;
  for (Engine* engine : {static_cast<Engine*>(&local), static_cast<Engine*>(remote.get())}) {
    ASSERT_EQ(engine->CreateScene("studio"), absl::OkStatus());
    ASSERT_EQ(engine->Commit("studio", Studio()).value(), 1u);
    auto artifact = ComputeOnce(*engine, "studio", FloorSpec());
    ASSERT_TRUE(artifact.ok()) << artifact.status();
    artifacts.push_back(*artifact);
  }
  const ArtifactHeader& a = artifacts[0]->header;
  const ArtifactHeader& b = artifacts[1]->header;
  EXPECT_EQ(CountsOf(*artifacts[0]), CountsOf(*artifacts[1]));
  EXPECT_THAT(CountsOf(*artifacts[1]), ::testing::Contains(0)) << "the box casts no shadow";
  EXPECT_EQ(a.light_samples, b.light_samples);
  EXPECT_EQ(a.parameters, b.parameters);
  EXPECT_EQ(a.scene_hash, b.scene_hash);
  EXPECT_EQ(a.revision, b.revision);
  EXPECT_EQ(a.pass, b.pass);
  EXPECT_TRUE(b.is_final);
  EXPECT_EQ(b.technique, "soft_texture");
  EXPECT_EQ(b.light_id, "lamp");
  EXPECT_EQ(b.receiver_id, "floor");
}

TEST_F(RemoteEngineTest, TwoClientsReceiveTheSameBitsOfTheSameRevision) {
  const auto alice = Connect();
  const auto bob = Connect();
  ASSERT_EQ(alice->CreateScene("studio"), absl::OkStatus());
  ASSERT_EQ(alice->Commit("studio", Studio()).value(), 1u);
  Inbox of_alice, of_bob;
  const auto first = alice->Subscribe("studio", FloorSpec(), of_alice.callback());
  const auto second = bob->Subscribe("studio", FloorSpec(), of_bob.callback());
  ASSERT_TRUE(first.ok() && second.ok());
  for (int step = 1; step <= 5; ++step) {
    const float x = 0.1f * static_cast<float>(step);
    const auto revision = alice->Commit("studio", Studio(Vec3(x, 0.5f, 0)));
    ASSERT_TRUE(revision.ok()) << revision.status();
    const auto a = of_alice.WaitForFinal(*revision);
    const auto b = of_bob.WaitForFinal(*revision);
    ASSERT_TRUE(a && b) << "revision " << *revision;
    EXPECT_EQ(a->revision, b->revision);
    EXPECT_EQ(CountsOf(*a->artifact), CountsOf(*b->artifact));
  }
  for (Inbox* inbox : {&of_alice, &of_bob}) {
    Revision before = 0;
    for (const ArtifactUpdate& update : inbox->updates()) {
      EXPECT_GE(update.revision, before) << "revisions out of order";
      before = update.revision;
    }
  }
}

TEST_F(RemoteEngineTest, ASubscriberReceivesTheArtifactOfEachMoveAsALocalEngineComputesIt) {
  const auto remote = Connect();
  ASSERT_EQ(remote->CreateScene("studio"), absl::OkStatus());
  ASSERT_TRUE(remote->Commit("studio", Studio()).ok());
  Inbox inbox;
  const auto subscription = remote->Subscribe("studio", FloorSpec(16), inbox.callback());
  ASSERT_TRUE(subscription.ok());
  for (const float x : {0.3f, -0.4f, 0.0f}) {
    const auto delta = Studio(Vec3(x, 0.5f, 0.2f));
    const auto revision = remote->Commit("studio", delta);
    ASSERT_TRUE(revision.ok());
    const auto update = inbox.WaitForFinal(*revision);
    ASSERT_TRUE(update);
    LocalEngine local;
    ASSERT_TRUE(local.CreateScene("fresh").ok() && local.Commit("fresh", delta).ok());
    const auto expected = ComputeOnce(local, "fresh", FloorSpec(16));
    ASSERT_TRUE(expected.ok());
    EXPECT_EQ(CountsOf(*update->artifact), CountsOf(**expected)) << "box at x = " << x;
  }
}

TEST_F(RemoteEngineTest, CallbacksThatWaitForOtherThreadsCommitsDoNotBlockThem) {
  const auto engine = Connect();
  ASSERT_EQ(engine->CreateScene("studio"), absl::OkStatus());
  ASSERT_TRUE(engine->Commit("studio", Studio()).ok());
  std::mutex shared;
  Inbox inbox;
  const auto subscription =
      engine->Subscribe("studio", FloorSpec(8), [&](const ArtifactUpdate& update) {
        std::lock_guard lock(shared);  // as a client would that guards its own state
        inbox.callback()(update);
      });
  ASSERT_TRUE(subscription.ok());
  Revision last = 0;
  for (int step = 0; step < 20; ++step) {
    std::lock_guard lock(shared);
    const auto revision = engine->Commit("studio", Studio(Vec3(0.05f * step, 0.5f, 0)));
    ASSERT_TRUE(revision.ok()) << revision.status();
    last = *revision;
  }
  EXPECT_TRUE(inbox.WaitForFinal(last));
}

TEST_F(RemoteEngineTest, ASlowCallbackMissesUpdatesAndThenSeesTheNewest) {
  const auto engine = Connect();
  ASSERT_EQ(engine->CreateScene("studio"), absl::OkStatus());
  ASSERT_TRUE(engine->Commit("studio", Studio()).ok());
  std::promise<void> entered, gate;
  auto open = gate.get_future().share();
  Inbox slow, quick;
  std::once_flag once;
  const auto first = engine->Subscribe("studio", FloorSpec(8), [&](const ArtifactUpdate& update) {
    std::call_once(once, [&] { entered.set_value(); });
    open.wait();
    slow.callback()(update);
  });
  const auto second = engine->Subscribe("studio", FloorSpec(16), quick.callback());
  ASSERT_TRUE(first.ok() && second.ok());
  entered.get_future().wait();
  Revision last = 0;
  for (int step = 0; step < 30; ++step) {
    const auto revision = engine->Commit("studio", Studio(Vec3(0.03f * step, 0.5f, 0)));
    ASSERT_TRUE(revision.ok()) << revision.status();
    last = *revision;
  }
  EXPECT_TRUE(quick.WaitForFinal(last)) << "the slow callback kept the other one waiting";
  gate.set_value();
  EXPECT_TRUE(slow.WaitForFinal(last));
  EXPECT_LT(slow.updates().size(), 20u) << "nothing was left out";
}

TEST_F(RemoteEngineTest, NoCallbackComesAfterItsSubscriptionIsGone) {
  const auto engine = Connect();
  ASSERT_EQ(engine->CreateScene("studio"), absl::OkStatus());
  ASSERT_TRUE(engine->Commit("studio", Studio()).ok());
  for (int round = 0; round < 20; ++round) {
    auto is_alive = std::make_unique<std::atomic<bool>>(true);
    auto subscription = engine->Subscribe("studio", FloorSpec(64), [&](const ArtifactUpdate&) {
      EXPECT_TRUE(is_alive->load());
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    });
    ASSERT_TRUE(subscription.ok());
    ASSERT_TRUE(engine->Commit("studio", Studio(Vec3(0.02f * round, 0.5f, 0))).ok());
    std::this_thread::sleep_for(std::chrono::microseconds(500 * round));
    subscription->reset();
    is_alive->store(false);
  }
}

TEST_F(RemoteEngineTest, UpdatesAreMeasuredOnTheWire) {
  const auto engine = Connect();
  ASSERT_EQ(engine->CreateScene("studio"), absl::OkStatus());
  ASSERT_TRUE(engine->Commit("studio", Studio()).ok());
  std::promise<UpdateTraffic> measured;
  std::once_flag once;
  const auto subscription = engine->SubscribeMeasured(
      "studio", FloorSpec(), [&](const ArtifactUpdate& update, const UpdateTraffic& traffic) {
        if (update.artifact && update.artifact->header.is_final) {
          std::call_once(once, [&] { measured.set_value(traffic); });
        }
      });
  ASSERT_TRUE(subscription.ok());
  auto future = measured.get_future();
  ASSERT_EQ(future.wait_for(kPatience), std::future_status::ready);
  const UpdateTraffic traffic = future.get();
  EXPECT_GE(traffic.messages, 1u);
  EXPECT_GT(traffic.bytes, 100u);
  EXPECT_LT(traffic.bytes, 96u * 96 * 2 + 4000) << "more than the texels take raw";
  EXPECT_GE(traffic.received_ms, traffic.since_ms);
}

// Of revisions that the mirror skips as well.
TEST_F(RemoteEngineTest, UpdatesAreTimedFromWhenTheirRevisionIsHeardOf) {
  const auto alice = Connect();
  const auto bob = Connect();
  ASSERT_EQ(alice->CreateScene("studio"), absl::OkStatus());
  ASSERT_TRUE(alice->Commit("studio", Studio()).ok());
  std::mutex mutex;
  std::vector<UpdateTraffic> of_edits;
  std::atomic<Revision> newest = 0;
  const auto subscription = bob->SubscribeMeasured(
      "studio", FloorSpec(), [&](const ArtifactUpdate& update, const UpdateTraffic& traffic) {
        std::lock_guard lock(mutex);
        if (update.revision > 1) of_edits.push_back(traffic);
        newest = update.revision;
      });
  ASSERT_TRUE(subscription.ok());
  ASSERT_TRUE(ComputeOnce(*bob, "studio", FloorSpec()).ok());
  const double start_ms = NowMs();
  Revision last = 0;
  for (int i = 0; i < 200; ++i) {
    last = alice->Commit("studio", Studio(Vec3(0.001f * i, 0.5f, 0))).value();
  }
  for (const auto end = std::chrono::steady_clock::now() + kPatience;
       newest < last && std::chrono::steady_clock::now() < end;) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  std::lock_guard lock(mutex);
  EXPECT_FALSE(of_edits.empty());
  for (const UpdateTraffic& traffic : of_edits) {
    EXPECT_GE(traffic.since_ms, start_ms);
    EXPECT_GE(traffic.received_ms, traffic.since_ms);
  }
}

}  // namespace
}  // namespace penumbra::testing
