// The method gl through an engine: on a GL worker's thread, again after a loss, refused without GL.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>

#include "render/engine/compute_once.h"
#include "render/engine/local_engine.h"
#include "render/gl/lazy_worker.h"
#include "render/scene/field_error.h"
#include "tests/gl/soft_texture/gl_scenes.h"
#include "tests/support/shapes.h"
#include "tests/support/test_device.h"

namespace penumbra::testing {
namespace {

using ::testing::HasSubstr;

const ArtifactSpec kSpec{
    .params = SoftTextureParams{.samples = 100, .radiance = true, .method = VisibilityMethod::kGl},
    .light_id = "light",
    .receiver_id = "receiver"};

SceneDelta BoxOverFloor() {
  return {.upsert_instances = {{.id = "box",
                                .mesh = MeshOf(UnitBoxGeometry()),
                                .world_from_mesh = Placed(Vec3(0.1f, 1.5f, 0.2f), 0.5f)}},
          .upsert_lights = {{"light", RectangleLight{.corner = Vec3(-0.5f, 4, 0.5f),
                                                     .edge_u = Vec3(1, 0, 0),
                                                     .edge_v = Vec3(0, 0, -1)}}},
          .upsert_receivers = {FloorReceiver("receiver", 4, 40)}};
}

// What soft_texture is, but that its context is lost while passes come in.
class LosingTechnique : public Technique {
 public:
  explicit LosingTechnique(int losses) : losses_left_(losses) {}

  const TechniqueInfo& info() const override { return inner_.info(); }
  absl::Status Check(const Scene& scene, const ArtifactSpec& spec) const override {
    return inner_.Check(scene, spec);
  }
  bool NeedsGl(const ArtifactSpec& spec) const override { return inner_.NeedsGl(spec); }
  absl::StatusOr<Artifact> Compute(const Scene& scene, const ArtifactSpec& spec,
                                   const ComputeContext& context) const override {
    ComputeContext losing = context;
    losing.progress = [&](Artifact pass) {
      context.progress(std::move(pass));
      if (losses_left_ > 0) {
        --losses_left_;
        context.gl->SimulateLoss();
      }
    };
    ++attempts;
    return inner_.Compute(scene, spec, losing);
  }

  mutable std::atomic<int> attempts = 0;

 private:
  const Technique& inner_ = TechniqueFor(SoftTextureParams{});
  mutable std::atomic<int> losses_left_;
};

class GlEngineTest : public ::testing::Test {
 protected:
  absl::StatusOr<std::shared_ptr<const Artifact>> Compute(LocalEngineOptions options) {
    LocalEngine engine(std::move(options));
    EXPECT_TRUE(engine.CreateScene("s").ok());
    EXPECT_TRUE(engine.Commit("s", BoxOverFloor()).ok());
    passes_.clear();
    return ComputeOnce(engine, "s", kSpec, {.progress = [this](const Artifact& artifact) {
                         passes_.push_back(artifact.header.pass);
                       }});
  }
  LocalEngineOptions WithGl() {
    return {.gl_worker = [this] { return worker_.Get(); }};
  }

  gl::LazyWorker worker_{{.context = {.device = TestDevice()}}};
  std::vector<uint32_t> passes_;
};

TEST_F(GlEngineTest, ComputesOnTheWorker) {
  const auto artifact = Compute(WithGl());
  ASSERT_TRUE(artifact.ok()) << artifact.status();
  EXPECT_EQ((*artifact)->header.parameters.at("method"), "gl");
  const auto scene = Scene::Empty("s")->Apply(BoxOverFloor()).value();
  const Artifact by_cpu = ComputeOnCpu(*scene, {.samples = 100});
  EXPECT_LE(DifferingSamples(**artifact, by_cpu), 1u);
  EXPECT_EQ(TextureOf(**artifact).radiance->texels.size(), 1600u);
}

TEST_F(GlEngineTest, ALossInTheMiddleChangesNothing) {
  const auto expected = Compute(WithGl());
  ASSERT_TRUE(expected.ok()) << expected.status();
  const LosingTechnique technique(1);
  LocalEngineOptions options = WithGl();
  options.technique_for = [&](const TechniqueParams&) -> const Technique& { return technique; };
  const auto artifact = Compute(std::move(options));
  ASSERT_TRUE(artifact.ok()) << artifact.status();
  EXPECT_EQ(technique.attempts, 2);
  EXPECT_EQ(worker_.Get().value()->rebuild_count(), 1);
  EXPECT_EQ(TextureOf(**artifact).visibility.counts, TextureOf(**expected).visibility.counts);
  EXPECT_EQ(TextureOf(**artifact).radiance->texels, TextureOf(**expected).radiance->texels);
  // No pass comes twice, although the second attempt made them again.
  for (size_t p = 1; p < passes_.size(); ++p) EXPECT_GT(passes_[p], passes_[p - 1]);
}

TEST_F(GlEngineTest, AJobThatLosesEveryContextEndsInAnError) {
  const LosingTechnique technique(1000);
  LocalEngineOptions options = WithGl();
  options.technique_for = [&](const TechniqueParams&) -> const Technique& { return technique; };
  const auto artifact = Compute(std::move(options));
  EXPECT_EQ(artifact.status().code(), absl::StatusCode::kUnavailable) << artifact.status();
  EXPECT_THAT(std::string(artifact.status().message()), HasSubstr("lost twice"));
  EXPECT_EQ(ErrorReason(artifact.status()), "GL_CONTEXT_LOST");
  EXPECT_EQ(technique.attempts, 2);
}

TEST_F(GlEngineTest, WithoutGlItIsRefused) {
  const auto artifact = Compute({});
  EXPECT_EQ(artifact.status().code(), absl::StatusCode::kFailedPrecondition) << artifact.status();
  EXPECT_EQ(ErrorReason(artifact.status()), "NO_GL");
  EXPECT_EQ(ErrorFieldPath(artifact.status()), "soft_texture.method");
  EXPECT_THAT(std::string(artifact.status().message()), HasSubstr("without OpenGL"));
}

TEST_F(GlEngineTest, WithoutADeviceItIsRefusedWithTheReason) {
  gl::LazyWorker nothing({.context = {.device = "voodoo2"}});
  const auto artifact = Compute({.gl_worker = [&] { return nothing.Get(); }});
  EXPECT_EQ(artifact.status().code(), absl::StatusCode::kFailedPrecondition) << artifact.status();
  EXPECT_EQ(ErrorReason(artifact.status()), "NO_GL");
  EXPECT_THAT(std::string(artifact.status().message()), HasSubstr("voodoo2"));
}

}  // namespace
}  // namespace penumbra::testing
