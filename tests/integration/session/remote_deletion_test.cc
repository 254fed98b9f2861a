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

}  // namespace
}  // namespace penumbra::testing
