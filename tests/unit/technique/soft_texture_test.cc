#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "render/scene/field_error.h"
#include "render/technique/technique.h"
#include "tests/unit/technique/soft_texture_scenes.h"

namespace penumbra {
namespace {

using testing::Ceiling;
using testing::Compute;
using testing::Floor;
using ::testing::HasSubstr;
using testing::RandomBoxes;
using testing::SceneOf;
using testing::TextureOf;

// A square of side 2 with a mask of 2×2 texels, its left half clear, parallel to the floor under a
// point light twice as high: the shadow is the right half of a square of side 4.
TEST(SoftTexture, LetsLightThroughTheMask) {
  SceneDelta delta;
  delta.upsert_instances = {{.id = "leaf",
                             .mesh = testing::MeshOf(testing::UnitSquareGeometry()),
                             .world_from_mesh = testing::Placed(Vec3(0, 1, 0)),
                             .alpha_mask = *AlphaMask::Create(2, 2, {0, 255, 0, 255})}};
  delta.upsert_lights = {{.id = "light", .shape = PointLight{.position = Vec3(0, 2, 0)}}};
  delta.upsert_receivers = {Floor(60, 60)};
  const auto artifact = Compute(*SceneOf(delta));
  ASSERT_TRUE(artifact.ok());
  const SoftShadowTexture& texture = TextureOf(*artifact);
  for (uint32_t j = 0; j < 60; ++j) {
    for (uint32_t i = 0; i < 60; ++i) {
      const Vec3 p = texture.receiver.TexelCenter(i, j);
      const bool dark = p.x > 0 && p.x < 2 && std::abs(p.z) < 2;
      ASSERT_EQ(texture.visibility.At(i, j), dark ? 0 : 1) << i << ", " << j;
    }
  }
}

// Behind a straight edge the visible fraction is that of the light's width: a closed form. The
// half-plane x < 0 at height 2 under a light of half-width 1 at height 4 leaves light samples with
// x > −x_floor visible.
TEST(SoftTexture, HasTheRampOfAStraightEdge) {
  SceneDelta delta;
  delta.upsert_instances = {{.id = "edge",
                             .mesh = testing::MeshOf(testing::UnitSquareGeometry()),
                             .world_from_mesh = testing::Placed(Vec3(-100, 2, 0), 100)}};
  delta.upsert_lights = {Ceiling()};
  delta.upsert_receivers = {Floor(60, 4)};
  const auto artifact = Compute(*SceneOf(delta), {.samples = 1024});
  ASSERT_TRUE(artifact.ok());
  const SoftShadowTexture& texture = TextureOf(*artifact);
  for (uint32_t i = 0; i < 60; ++i) {
    const float x = texture.receiver.TexelCenter(i, 1).x;
    EXPECT_NEAR(texture.visibility.Fraction(i, 1), std::clamp((1 + x) / 2, 0.0f, 1.0f), 0.02f) << x;
  }
}

TEST(SoftTexture, GivesTheSameBitsForAnyNumberOfThreadsAndPasses) {
  SceneDelta delta = RandomBoxes(20, 9);
  delta.upsert_receivers = {Floor(131, 67)};
  delta.upsert_lights = {Ceiling()};
  const auto scene = SceneOf(delta);
  const Artifact one = Compute(*scene, {.samples = 100}, 1).value();
  for (const int threads : {2, 4}) {
    EXPECT_EQ(TextureOf(Compute(*scene, {.samples = 100}, threads).value()).visibility.counts,
              TextureOf(one).visibility.counts);
  }
  tbb::task_arena arena(2);
  std::vector<uint32_t> sample_counts;
  const ArtifactSpec spec{SoftTextureParams{.samples = 100}, "light", "floor"};
  const ComputeContext context{
      .arena = arena,
      .gl = nullptr,
      .stop = {},
      .progress =
          [&](const Artifact& artifact) {
            EXPECT_FALSE(artifact.header.is_final);
            sample_counts.push_back(TextureOf(artifact).visibility.sample_count);
          },
      .now_ms = {}};
  const auto progressive = TechniqueFor(spec.params).Compute(*scene, spec, context);
  EXPECT_EQ(TextureOf(*progressive).visibility.counts, TextureOf(one).visibility.counts);
  EXPECT_TRUE(progressive->header.is_final);
  EXPECT_EQ(sample_counts, (std::vector<uint32_t>{8, 64}));
}

TEST(SoftTexture, SurvivesGeometryThatCastsNothing) {
  const auto mesh = [](MeshGeometry geometry) { return testing::MeshOf(std::move(geometry)); };
  SceneDelta delta;
  delta.upsert_instances = {
      {.id = "empty", .mesh = mesh({})},
      {.id = "no-triangles",
       .mesh = mesh({.positions = {{0, 1, 0}}, .indices = {}, .normals = {}, .uvs = {}})},
      {.id = "point",
       .mesh = mesh({.positions = {{0, 1, 0}}, .indices = {0, 0, 0}, .normals = {}, .uvs = {}})},
      {.id = "needle",
       .mesh = mesh({.positions = {{0, 1, 0}, {1, 1, 0}, {2, 1, 0}},
                     .indices = {0, 1, 2},
                     .normals = {},
                     .uvs = {}})},
      {.id = "scaled-away",
       .mesh = mesh(testing::UnitBoxGeometry()),
       .world_from_mesh = testing::Placed(Vec3(0, 1, 0), 0)},
      {.id = "in-the-floor",
       .mesh = mesh(testing::UnitSquareGeometry()),
       .world_from_mesh = testing::Placed(Vec3(0), 3)},
      {.id = "below",
       .mesh = mesh(testing::UnitBoxGeometry()),
       .world_from_mesh = testing::Placed(Vec3(0, -2, 0))},
      {.id = "above-the-light",
       .mesh = mesh(testing::UnitBoxGeometry()),
       .world_from_mesh = testing::Placed(Vec3(0, 6, 0))},
      {.id = "does-not-cast",
       .mesh = mesh(testing::UnitBoxGeometry()),
       .world_from_mesh = testing::Placed(Vec3(0, 2, 0)),
       .casts = false}};
  delta.upsert_receivers = {Floor(32, 32)};
  delta.upsert_lights = {Ceiling()};
  const auto artifact = Compute(*SceneOf(delta));
  ASSERT_TRUE(artifact.ok());
  for (const uint16_t count : TextureOf(*artifact).visibility.counts) ASSERT_EQ(count, 64);
}

TEST(SoftTexture, A14DefinesALightInTheReceiversPlane) {
  SceneDelta delta = RandomBoxes(4, 3);
  delta.upsert_receivers = {Floor(16, 16)};
  delta.upsert_lights = {
      {.id = "light",
       .shape = RectangleLight{
           .corner = Vec3(-1, 0, -1), .edge_u = Vec3(2, 0, 0), .edge_v = Vec3(0, 0, 2)}}};
  const auto artifact = Compute(*SceneOf(delta), {.radiance = true});
  ASSERT_TRUE(artifact.ok());
  for (const uint16_t count : TextureOf(*artifact).visibility.counts) EXPECT_EQ(count, 64);
  for (const Vec3& texel : TextureOf(*artifact).radiance->texels) {
    EXPECT_TRUE(IsFinite(texel));
  }
}

TEST(SoftTexture, StopsWhenAsked) {
  SceneDelta delta = RandomBoxes(4, 3);
  delta.upsert_receivers = {Floor(16, 16)};
  delta.upsert_lights = {Ceiling()};
  const auto scene = SceneOf(delta);
  std::stop_source source;
  source.request_stop();
  tbb::task_arena arena(1);
  const ArtifactSpec spec{SoftTextureParams{}, "light", "floor"};
  const ComputeContext context{
      .arena = arena, .gl = nullptr, .stop = source.get_token(), .progress = {}, .now_ms = {}};
  EXPECT_EQ(TechniqueFor(spec.params).Compute(*scene, spec, context).status().code(),
            absl::StatusCode::kCancelled);
}

TEST(SoftTexture, NamesWhatIsWrong) {
  SceneDelta delta;
  delta.upsert_receivers = {Floor(16, 16)};
  delta.upsert_lights = {Ceiling()};
  const auto scene = SceneOf(delta);
  for (const uint32_t samples : {0u, 1025u, 0x80000000u}) {
    const auto status = Compute(*scene, {.samples = samples}).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(status.message()), HasSubstr("soft_texture.samples: found "));
  }
  const ArtifactSpec no_light{SoftTextureParams{}, "sun", "floor"};
  const auto light_status = TechniqueFor(no_light.params).Check(*scene, no_light);
  EXPECT_EQ(light_status.code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(ErrorFieldPath(light_status), "light_id");
  const ArtifactSpec no_receiver{SoftTextureParams{}, "light", "wall"};
  EXPECT_EQ(TechniqueFor(no_receiver.params).Check(*scene, no_receiver).code(),
            absl::StatusCode::kNotFound);
}

TEST(SoftTexture, HandlesGridsOfManyBands) {
  SceneDelta delta = RandomBoxes(6, 2);
  delta.upsert_lights = {Ceiling()};
  // 8192 columns of 256 words: bands of 256 rows. The coarse grid's texel centres recur in the fine
  // one where the ratio is odd.
  delta.upsert_receivers = {Floor(8191, 301)};
  const auto fine = Compute(*SceneOf(delta), {.samples = 4});
  ASSERT_TRUE(fine.ok());
  delta.upsert_receivers = {Floor(8191, 43)};
  const auto coarse = Compute(*SceneOf(delta), {.samples = 4});
  int differing = 0;
  for (uint32_t j = 0; j < 43; ++j) {
    for (uint32_t i = 0; i < 8191; ++i) {
      differing +=
          TextureOf(*fine).visibility.At(i, 7 * j + 3) != TextureOf(*coarse).visibility.At(i, j);
    }
  }
  EXPECT_LT(differing, 8191 * 43 / 2000);
}

}  // namespace
}  // namespace penumbra
