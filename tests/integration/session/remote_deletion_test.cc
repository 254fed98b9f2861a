// Scenes that are deleted while somebody waits for their artifacts.
#include <gtest/gtest.h>

#include <functional>
#include <future>
#include <memory>
#include <stop_token>
#include <string>
#include <thread>

#include "render/scene/field_error.h"
#include "render/technique/technique.h"
#include "tests/integration/session/remote_engine_fixture.h"

namespace penumbra::testing {
namespace {

// Computes until it is stopped.
class EndlessTechnique : public Technique {
 public:
  const TechniqueInfo& info() const override { return SoftTextureParams::kInfo; }
  absl::Status Check(const Scene&, const ArtifactSpec&) const override { return absl::OkStatus(); }
  absl::StatusOr<Artifact> Compute(const Scene&, const ArtifactSpec&,
                                   const ComputeContext& context) const override {
    while (!context.stop.stop_requested()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return absl::CancelledError("stopped");
  }
};

class DeletionTest : public RemoteEngineTest {
 protected:
  void SetUp() override {
    auto server = PenumbraServer::Start(
        {.listen = "127.0.0.1:0",
         .opens_gl = false,
         .technique_for = [this](const auto&) -> const Technique& { return technique_; }});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }
  void TearDown() override { server_.reset(); }

  // What ComputeOnce ends with when `remove` deletes the scene before the first update.
  absl::Status StatusWhen(RemoteEngine& engine, const std::function<absl::Status()>& remove) {
    std::stop_source stop;
    auto waiting = std::async(std::launch::async, [&] {
      return ComputeOnce(engine, "studio", FloorSpec(), {.stop = stop.get_token()}).status();
    });
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (!IsFollowed(engine) && std::chrono::steady_clock::now() < end) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    EXPECT_EQ(remove(), absl::OkStatus());
    const bool has_ended = waiting.wait_for(kPatience / 4) == std::future_status::ready;
    EXPECT_TRUE(has_ended) << "it waits for ever";
    if (!has_ended) stop.request_stop();
    return waiting.get();
  }

 private:
  static bool IsFollowed(RemoteEngine& engine) {
    const std::string info = engine.ServerInfoJson().value_or("");
    return info.find("\"open_subscriptions\":\"1\"") != std::string::npos;
  }

  EndlessTechnique technique_;
};

TEST_F(DeletionTest, ByAnotherEndsWhatWaitsForTheFirstArtifact) {
  const auto alice = Connect();
  const auto bob = Connect();
  ASSERT_EQ(alice->CreateScene("studio"), absl::OkStatus());
  ASSERT_TRUE(alice->Commit("studio", Studio()).ok());
  const absl::Status by_another = StatusWhen(*alice, [&] { return bob->DeleteScene("studio"); });
  EXPECT_EQ(by_another.code(), absl::StatusCode::kNotFound) << by_another;
  EXPECT_EQ(ErrorReason(by_another), "UNKNOWN_ID");
  EXPECT_EQ(ErrorFieldPath(by_another), "scene_id");
}

TEST_F(DeletionTest, ByItselfEndsWhatWaitsForTheFirstArtifact) {
  const auto alice = Connect();
  ASSERT_EQ(alice->CreateScene("studio"), absl::OkStatus());
  ASSERT_TRUE(alice->Commit("studio", Studio()).ok());
  const absl::Status by_itself = StatusWhen(*alice, [&] { return alice->DeleteScene("studio"); });
  EXPECT_EQ(by_itself.code(), absl::StatusCode::kNotFound) << by_itself;
  EXPECT_EQ(ErrorReason(by_itself), "UNKNOWN_ID") << "as a LocalEngine says it";
  EXPECT_EQ(ErrorFieldPath(by_itself), "scene_id");
}

// What follows a deletion at once crosses the end of the deleted scene's session: once is no proof.
constexpr int kRounds = 40;

TEST_F(RemoteEngineTest, AfterADeletionAnotherSceneMayHaveTheId) {
  const auto alice = Connect();
  const auto bob = Connect();
  for (int i = 0; i < kRounds; ++i) {
    ASSERT_EQ(alice->CreateScene("studio"), absl::OkStatus());
    ASSERT_TRUE(alice->Commit("studio", Studio()).ok());
    Inbox of_alice, of_bob;
    const auto first = alice->Subscribe("studio", FloorSpec(), of_alice.callback());
    const auto second = bob->Subscribe("studio", FloorSpec(), of_bob.callback());
    ASSERT_TRUE(first.ok() && second.ok());
    ASSERT_EQ(alice->DeleteScene("studio"), absl::OkStatus());
    ASSERT_TRUE(of_alice.WaitForError(absl::StatusCode::kNotFound));
    ASSERT_TRUE(of_bob.WaitForError(absl::StatusCode::kNotFound));

    ASSERT_EQ(alice->CreateScene("studio"), absl::OkStatus());
    const auto revision = bob->Commit("studio", Studio());
    ASSERT_TRUE(revision.ok()) << "round " << i << ": " << revision.status();
    EXPECT_EQ(*revision, 1u);
    EXPECT_TRUE(ComputeOnce(*alice, "studio", FloorSpec()).ok());
    ASSERT_EQ(bob->DeleteScene("studio"), absl::OkStatus());
  }
}

TEST_F(RemoteEngineTest, WhoCreatesASceneUsesThatOneAndNoneOfTheSameIdFromBefore) {
  const auto alice = Connect();
  const auto bob = Connect();
  // Keeps bob's session busy, so that its end comes late.
  SceneDelta many;
  for (int box = 0; box < 2000; ++box) {
    many.upsert_instances.push_back(Studio().upsert_instances[0]);
    many.upsert_instances.back().id = "box-" + std::to_string(box);
  }
  for (int i = 0; i < kRounds; ++i) {
    ASSERT_EQ(alice->CreateScene("studio"), absl::OkStatus());
    ASSERT_TRUE(bob->Commit("studio", Studio()).ok());
    ASSERT_TRUE(alice->Commit("studio", many).ok());
    ASSERT_EQ(alice->DeleteScene("studio"), absl::OkStatus());

    ASSERT_EQ(bob->CreateScene("studio"), absl::OkStatus()) << "nothing tells bob of the deletion";
    EXPECT_EQ((*bob->Snapshot("studio"))->revision(), 0u);
    const auto revision = bob->Commit("studio", Studio());
    ASSERT_TRUE(revision.ok()) << "round " << i << ": " << revision.status();
    EXPECT_EQ(*revision, 1u);
    ASSERT_EQ(alice->DeleteScene("studio"), absl::OkStatus());
  }
}

}  // namespace
}  // namespace penumbra::testing
