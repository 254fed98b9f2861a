// A server, and the small scene that its tests share: a box over a floor under a square light.
#pragma once

#include <memory>
#include <string>

#include "gtest/gtest.h"
#include "server/penumbra_server.h"
#include "tests/integration/service/wire_client.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {

inline std::unique_ptr<PenumbraServer> StartServer(ServerOptions options = {}) {
  options.listen = "127.0.0.1:0";
  options.threads = 2;
  options.opens_gl = false;
  // Tests share their machine: a processor that is busy with others says nothing of this server.
  options.limits.max_read_delay_ms = 60'000;
  return PenumbraServer::Start(options).value();
}

inline std::shared_ptr<const Mesh> BoxMesh() {
  static const auto mesh = MeshOf(UnitBoxGeometry());
  return mesh;
}

inline Instance Box(Vec3 position, const std::string& id = "box") {
  return {.id = id, .mesh = BoxMesh(), .world_from_mesh = Placed(position, 0.3f)};
}

inline AreaLight SquareLight(float height = 3.0f) {
  return {.id = "lamp",
          .shape = RectangleLight{
              .corner = {-0.5f, height, -0.5f}, .edge_u = {1, 0, 0}, .edge_v = {0, 0, 1}}};
}

inline SceneDelta StudioDelta(uint32_t texels = 128) {
  SceneDelta delta;
  delta.upsert_instances = {Box({0, 1, 0})};
  delta.upsert_lights = {SquareLight()};
  delta.upsert_receivers = {FloorReceiver("floor", 4.0f, texels)};
  return delta;
}

inline SceneDelta MoveBox(Vec3 position) {
  SceneDelta delta;
  delta.upsert_instances = {Box(position)};
  return delta;
}

inline ArtifactSpec FloorSpec(uint32_t samples = 16) {
  return {
      .params = SoftTextureParams{.samples = samples}, .light_id = "lamp", .receiver_id = "floor"};
}

// A server with the scene "studio" in it, at revision 1.
class StudioTest : public ::testing::Test {
 protected:
  void SetUp() override {
    server_ = StartServer(options_);
    client_ = std::make_unique<WireClient>(server_->address());
    ASSERT_EQ(client_->CreateScene("studio"), absl::OkStatus());
    ASSERT_EQ(client_->Upload(*BoxMesh()), absl::OkStatus());
    session_ = client_->OpenSession("studio");
    const auto result = session_->Commit(StudioDelta());
    ASSERT_EQ(result.revision(), 1u) << result.error().message();
  }

  ServerOptions options_;
  std::unique_ptr<PenumbraServer> server_;
  std::unique_ptr<WireClient> client_;
  std::unique_ptr<WireSession> session_;
};

}  // namespace penumbra::testing
