// A server in this process, clients of it, and a small scene.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/session/remote_engine.h"
#include "render/engine/compute_once.h"
#include "render/engine/local_engine.h"
#include "server/penumbra_server.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {

inline constexpr std::chrono::seconds kPatience(20);

// A box over a floor under a square lamp.
inline SceneDelta Studio(Vec3 box_position = Vec3(0, 0.5f, 0)) {
  static const auto box = MeshOf(UnitBoxGeometry());
  SceneDelta delta;
  delta.upsert_instances = {
      {.id = "box", .mesh = box, .world_from_mesh = Placed(box_position, 0.4f)}};
  delta.upsert_lights = {
      {.id = "lamp",
       .shape =
           RectangleLight{.corner = {-0.5f, 3, -0.5f}, .edge_u = {1, 0, 0}, .edge_v = {0, 0, 1}}}};
  delta.upsert_receivers = {FloorReceiver("floor", 4.0f, 96)};
  return delta;
}

inline ArtifactSpec FloorSpec(uint32_t samples = 64) {
  return {SoftTextureParams{.samples = samples}, "lamp", "floor"};
}

inline const std::vector<uint16_t>& CountsOf(const Artifact& artifact) {
  return std::get<SoftShadowTexture>(artifact.payload).visibility.counts;
}

// Keeps every update; waits for one that fits.
class Inbox {
 public:
  ArtifactCallback callback() {
    return [this](const ArtifactUpdate& update) {
      std::lock_guard lock(mutex_);
      updates_.push_back(update);
      came_.notify_all();
    };
  }

  template <typename Predicate>
  std::optional<ArtifactUpdate> WaitFor(Predicate fits) {
    std::unique_lock lock(mutex_);
    const auto find = [&] { return std::find_if(updates_.begin(), updates_.end(), fits); };
    came_.wait_for(lock, kPatience, [&] { return find() != updates_.end(); });
    const auto found = find();
    return found == updates_.end() ? std::nullopt : std::optional(*found);
  }
  std::optional<ArtifactUpdate> WaitForFinal(Revision revision) {
    return WaitFor([revision](const ArtifactUpdate& update) {
      return update.revision >= revision && update.artifact && update.artifact->header.is_final;
    });
  }
  std::optional<ArtifactUpdate> WaitForError(absl::StatusCode code) {
    return WaitFor([code](const ArtifactUpdate& update) { return update.status.code() == code; });
  }
  std::vector<ArtifactUpdate> updates() {
    std::lock_guard lock(mutex_);
    return updates_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable came_;
  std::vector<ArtifactUpdate> updates_;
};

class RemoteEngineTest : public ::testing::Test {
 protected:
  void SetUp() override { Start("127.0.0.1:0"); }

  void Start(const std::string& listen) {
    auto server = PenumbraServer::Start({.listen = listen, .opens_gl = false});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }

  // By default a session ends with its connection.
  std::unique_ptr<RemoteEngine> Connect(double reconnect_for_s = 0) {
    auto engine =
        RemoteEngine::Connect({.address = server_->address(), .reconnect_for_s = reconnect_for_s});
    EXPECT_TRUE(engine.ok()) << engine.status();
    return *std::move(engine);
  }

  std::unique_ptr<PenumbraServer> server_;
};

}  // namespace penumbra::testing
