// The method gl by way of a server: asked for over the wire, refused by a server without GL.
#include <gmock/gmock.h>

#include "render/scene/field_error.h"
#include "tests/integration/session/remote_engine_fixture.h"

namespace penumbra::testing {
namespace {

ArtifactSpec GlSpec() {
  return {SoftTextureParams{.radiance = true, .method = VisibilityMethod::kGl}, "lamp", "floor"};
}

absl::StatusOr<std::shared_ptr<const Artifact>> ComputeOn(bool opens_gl, const ArtifactSpec& spec) {
  auto server = PenumbraServer::Start(
      {.listen = "127.0.0.1:0", .egl_device = "software", .opens_gl = opens_gl});
  if (!server.ok()) return server.status();
  auto engine = RemoteEngine::Connect({.address = (*server)->address()});
  if (!engine.ok()) return engine.status();
  EXPECT_TRUE((*engine)->CreateScene("s").ok());
  EXPECT_TRUE((*engine)->Commit("s", Studio()).ok());
  return ComputeOnce(**engine, "s", spec);
}

TEST(GlMethodTest, AServerWithGlComputesIt) {
  const auto by_gl = ComputeOn(true, GlSpec());
  ASSERT_TRUE(by_gl.ok()) << by_gl.status();
  EXPECT_EQ((*by_gl)->header.parameters.at("method"), "gl");
  EXPECT_TRUE(std::get<SoftShadowTexture>((*by_gl)->payload).radiance);
  const auto by_cpu = ComputeOn(false, FloorSpec());
  ASSERT_TRUE(by_cpu.ok()) << by_cpu.status();
  size_t differing = 0, hidden = 0;
  for (size_t t = 0; t < CountsOf(**by_cpu).size(); ++t) {
    differing += CountsOf(**by_gl)[t] != CountsOf(**by_cpu)[t];
    hidden += CountsOf(**by_cpu)[t] < 64;
  }
  EXPECT_LE(differing, 5u);
  EXPECT_GT(hidden, 100u);
}

TEST(GlMethodTest, AServerWithoutGlRefusesIt) {
  const absl::Status status = ComputeOn(false, GlSpec()).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition) << status;
  EXPECT_EQ(ErrorReason(status), "NO_GL");
  EXPECT_EQ(ErrorFieldPath(status), "soft_texture.method");
  EXPECT_THAT(std::string(status.message()), ::testing::HasSubstr("switched off"));
}

}  // namespace
}  // namespace penumbra::testing
