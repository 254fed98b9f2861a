// The renderer by itself: many receivers at a time, pages, what is kept, sizes, refusals.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"
#include "render/technique/soft_texture/gl/shadow_renderer.h"
#include "tests/gl/display/software_context.h"
#include "tests/gl/soft_texture/gl_scenes.h"
#include "tests/support/random_scene.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

using ::testing::HasSubstr;
using texture_gl::ShadowRenderer;
using texture_gl::ShadowRequest;

const AreaLight kLamp{"light", RectangleLight{.corner = Vec3(-0.5f, 3, 0.5f),
                                              .edge_u = Vec3(1, 0, 0),
                                              .edge_v = Vec3(0, 0, -1)}};

std::shared_ptr<const Scene> BoxesOver(uint32_t width, uint32_t height) {
  Receiver receiver = FloorReceiver("receiver", 4, width);
  receiver.height = height;
  SceneDelta delta{.upsert_lights = {kLamp}, .upsert_receivers = {receiver}};
  Dice dice(5);
  for (int i = 0; i < 12; ++i) {
    delta.upsert_instances.push_back(
        {.id = absl::StrCat("box", i),
         .mesh = MeshOf(UnitBoxGeometry()),
         .world_from_mesh = dice.AnyAffine(0.2f, Vec3(0, 1.2f, 0) + dice.InCube(1))});
  }
  return Scene::Empty("s")->Apply(delta).value();
}

class ShadowRendererTest : public SoftwareContextTest {
 protected:
  // All differences from the CPU, of all texel-samples.
  void ExpectAgreement(const Scene& scene, uint32_t samples) {
    const auto by_gl = ComputeOnGl(*context_, scene, {.samples = samples});
    ASSERT_TRUE(by_gl.ok()) << by_gl.status();
    const Artifact by_cpu = ComputeOnCpu(scene, {.samples = samples});
    const auto& counts = TextureOf(by_cpu).visibility.counts;
    EXPECT_LE(DifferingSamples(*by_gl, by_cpu), counts.size() * samples / 100'000 + 1);
    EXPECT_TRUE(counts.size() == 1 || *std::min_element(counts.begin(), counts.end()) < samples);
  }
};

TEST_F(ShadowRendererTest, AnyNumberOfSamples) {
  for (const uint32_t samples : {1u, 63u, 64u, 65u, 128u, 1024u}) {
    SCOPED_TRACE(samples);
    ExpectAgreement(*BoxesOver(61, 47), samples);
  }
}

TEST_F(ShadowRendererTest, AnySize) {
  for (const auto& [width, height] : {std::pair{1u, 1u}, std::pair{1u, 97u}, std::pair{4096u, 3u},
                                      std::pair{3u, 4096u}, std::pair{1031u, 1021u}}) {
    SCOPED_TRACE(absl::StrCat(width, " x ", height));
    ExpectAgreement(*BoxesOver(width, height), 20);
  }
}

// Boxes through the receiver's plane and around the light, sheets level with the light.
TEST_F(ShadowRendererTest, OccludersThatCrossPlanesAreCutThere) {
  Dice dice(11);
  uint64_t differing = 0, texel_samples = 0;
  for (int trial = 0; trial < 40; ++trial) {
    SceneDelta delta{.upsert_lights = {kLamp},
                     .upsert_receivers = {FloorReceiver("receiver", 4, 50)}};
    const auto add = [&](MeshGeometry mesh, const Affine& place) {
      delta.upsert_instances.push_back({.id = absl::StrCat("i", delta.upsert_instances.size()),
                                        .mesh = MeshOf(std::move(mesh)),
                                        .world_from_mesh = place});
    };
    add(UnitBoxGeometry(), dice.AnyAffine(0.4f, 1.5f * Vec3(dice.Between(-1, 1), 0, 0)));
    add(UnitSquareGeometry(), dice.AnyAffine(0.6f, Vec3(dice.Between(-1, 1), 3, 0.2f)));
    add(UnitSquareGeometry(), dice.AnyAffine(2.5f, Vec3(2, 2, dice.Between(-1, 1))));
    const auto scene = Scene::Empty("s")->Apply(delta).value();
    const auto by_gl = ComputeOnGl(*context_, *scene, {.samples = 32});
    ASSERT_TRUE(by_gl.ok()) << by_gl.status();
    differing += DifferingSamples(*by_gl, ComputeOnCpu(*scene, {.samples = 32}));
    texel_samples += 2500 * 32;
  }
  EXPECT_LE(differing, texel_samples / 100'000);
}

TEST_F(ShadowRendererTest, MasksAreLookedUpAsOnTheCpu) {
  Dice dice(3);
  uint64_t differing = 0, hidden = 0;
  for (const float cutoff : {0.0f, 0.3f, 0.5f, 128 / 255.0f, 1.0f}) {
    std::vector<uint8_t> alpha(7 * 5);
    for (uint8_t& a : alpha) a = static_cast<uint8_t>(dice.Below(8) * 36);
    alpha[3] = 128;
    alpha[4] = 255;
    MeshGeometry sheet = UnitSquareGeometry();
    for (Vec2& uv : sheet.uvs) uv = 3.0f * uv - 1.2f;  // repeats, below 0 too
    Instance leaf{.id = "leaf",
                  .mesh = MeshOf(std::move(sheet)),
                  .world_from_mesh = dice.AnyAffine(1.0f, Vec3(0, 1, 0))};
    leaf.alpha_mask = AlphaMask::Create(7, 5, alpha).value();
    leaf.alpha_cutoff = cutoff;
    const auto scene = Scene::Empty("s")
                           ->Apply({.upsert_instances = {leaf},
                                    .upsert_lights = {kLamp},
                                    .upsert_receivers = {FloorReceiver("receiver", 4, 128)}})
                           .value();
    const auto by_gl = ComputeOnGl(*context_, *scene, {.samples = 16});
    ASSERT_TRUE(by_gl.ok()) << by_gl.status();
    differing += DifferingSamples(*by_gl, ComputeOnCpu(*scene, {.samples = 16}));
    for (const uint16_t count : TextureOf(*by_gl).visibility.counts) hidden += 16 - count;
  }
  EXPECT_LE(differing, 5u * 128 * 128 * 16 / 100'000);
  EXPECT_GT(hidden, 10000u);
}

TEST_F(ShadowRendererTest, ABatchIsWhatSingleCallsAre) {
  std::vector<std::shared_ptr<const Scene>> scenes;
  std::vector<ReceiverPatch> receivers;
  std::vector<std::vector<LightSample>> samples;
  for (uint64_t seed = 0; seed < 24; ++seed) {
    scenes.push_back(RandomScene(seed));
    receivers.push_back(scenes.back()->ResolveReceiver("receiver").value());
    samples.push_back(SampleLight(*scenes.back()->FindLight("light"),
                                  5 + 7 * static_cast<uint32_t>(seed), 1, Vec3(0)));
  }
  std::vector<ShadowRequest> requests;
  for (size_t r = 0; r < scenes.size(); ++r) {
    const auto light = scenes[r]->FindLight("light");
    requests.push_back({*scenes[r], receivers[r], 1e-5, samples[r], r % 3 ? light.get() : nullptr});
  }
  ShadowRenderer& renderer = **ShadowRenderer::Of(*context_);
  const auto batch = renderer.Draw(*context_, requests, {});
  ASSERT_TRUE(batch.ok()) << batch.status();
  for (size_t r = 0; r < requests.size(); ++r) {
    const auto single = renderer.Draw(*context_, std::span(&requests[r], 1), {});
    ASSERT_TRUE(single.ok()) << single.status();
    EXPECT_EQ((*batch)[r].hidden, single->front().hidden) << r;
    EXPECT_EQ((*batch)[r].radiance, single->front().radiance) << r;
    EXPECT_EQ((*batch)[r].radiance.empty(), r % 3 == 0) << r;
  }
}

TEST_F(ShadowRendererTest, MeshesAreUploadedOnce) {
  const auto scene = BoxesOver(20, 20);
  ASSERT_TRUE(ComputeOnGl(*context_, *scene, {}).ok());
  const ShadowRenderer& renderer = **ShadowRenderer::Of(*context_);
  EXPECT_EQ(renderer.meshes().upload_count(), 1u);  // twelve boxes are one mesh
  Instance ball = *scene->FindInstance("box3");
  ball.mesh = MeshOf(UnitSquareGeometry());
  ball.world_from_mesh = Placed(Vec3(0, 1, 0));
  const auto edited = scene->Apply({.upsert_instances = {ball}}).value();
  ASSERT_TRUE(ComputeOnGl(*context_, *edited, {}).ok());
  EXPECT_EQ(renderer.meshes().upload_count(), 2u);
  EXPECT_EQ(renderer.meshes().bytes(), 8 * 12u + 36 * 4u + 4 * 12u + 6 * 4u + 4 * 8u);
}

TEST_F(ShadowRendererTest, TheStoreDropsWhatWasAskedForLongestAgo) {
  const auto box = MeshOf(UnitBoxGeometry()), square = MeshOf(UnitSquareGeometry());
  MeshGeometry geometry = UnitBoxGeometry();
  geometry.positions[0] *= 2.0f;
  const auto other = MeshOf(std::move(geometry));
  MeshStore store(2 * (8 * 12 + 36 * 4));
  ASSERT_TRUE(store.Mesh(*context_, *box, "a.method").ok());
  ASSERT_TRUE(store.Mesh(*context_, *square, "a.method").ok());
  ASSERT_TRUE(store.Mesh(*context_, *box, "a.method").ok());
  ASSERT_TRUE(store.Mesh(*context_, *other, "a.method").ok());  // the square goes
  EXPECT_EQ(store.upload_count(), 3u);
  ASSERT_TRUE(store.Mesh(*context_, *box, "a.method").ok());
  EXPECT_EQ(store.upload_count(), 3u);
  EXPECT_EQ(store.bytes(), 2 * (8 * 12 + 36 * 4u));
  const auto mask = AlphaMask::Create(17, 15, std::vector<uint8_t>(255)).value();
  const absl::Status refused = store.Mask(*context_, *mask, *box, "a.method").status();
  EXPECT_EQ(refused.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(ErrorReason(refused), "GL_MEMORY");
  EXPECT_EQ(ErrorFieldPath(refused), "a.method");
  EXPECT_THAT(std::string(refused.message()), HasSubstr("255 bytes, need at most 240"));
}

TEST_F(ShadowRendererTest, AStopIsHeard) {
  const auto scene = BoxesOver(20, 20);
  const ArtifactSpec spec{.params = SoftTextureParams{.method = VisibilityMethod::kGl},
                          .light_id = "light",
                          .receiver_id = "receiver"};
  std::stop_source source;
  tbb::task_arena arena(1);
  int passes = 0;
  const auto stopped = TechniqueFor(spec.params)
                           .Compute(*scene, spec,
                                    {.arena = arena,
                                     .gl = context_.get(),
                                     .stop = source.get_token(),
                                     .progress = [&](Artifact) {
                                       ++passes;
                                       source.request_stop();
                                     }});
  EXPECT_EQ(passes, 1);
  EXPECT_EQ(stopped.status().code(), absl::StatusCode::kCancelled) << stopped.status();
}

}  // namespace
}  // namespace penumbra::testing
