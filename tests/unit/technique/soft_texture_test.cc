#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "render/scene/field_error.h"
#include "render/technique/technique.h"
#include "tests/support/shapes.h"

namespace penumbra {
namespace {

using ::testing::HasSubstr;

// A floor of `side` metres around the origin, facing up.
Receiver Floor(uint32_t width, uint32_t height, float side = 6) {
  return {.id = "floor",
          .shape = Parallelogram{.origin = Vec3(-side / 2, 0, side / 2),
                                 .edge_u = Vec3(side, 0, 0),
                                 .edge_v = Vec3(0, 0, -side)},
          .width = width,
          .height = height};
}

AreaLight Ceiling(float height = 4) {
  return {.id = "light",
          .shape = RectangleLight{
              .corner = Vec3(-1, height, -1), .edge_u = Vec3(2, 0, 0), .edge_v = Vec3(0, 0, 2)}};
}

std::shared_ptr<const Scene> SceneOf(SceneDelta delta) {
  return Scene::Empty("test")->Apply(delta).value();
}

absl::StatusOr<Artifact> Compute(const Scene& scene, SoftTextureParams params = {},
                                 int threads = 2) {
  tbb::task_arena arena(threads);
  const ArtifactSpec spec{.params = params, .light_id = "light", .receiver_id = "floor"};
  const ComputeContext context{
      .arena = arena, .gl = nullptr, .stop = {}, .progress = {}, .now_ms = {}};
  return TechniqueFor(spec.params).Compute(scene, spec, context);
}

const SoftShadowTexture& TextureOf(const Artifact& artifact) {
  return std::get<SoftShadowTexture>(artifact.payload);
}

// Whether some triangle blocks the open segment from `from` towards the sample, in double
// precision, by signs of volumes. Sets `grazing` when a volume is too small to trust.
bool Blocked(const Scene& scene, DVec3 from, const LightSample& sample, bool& grazing) {
  const DVec3 direction = sample.at_infinity ? DVec3(sample.point) : DVec3(sample.point) - from;
  bool blocked = false;
  for (const auto& [id, instance] : scene.instances()) {
    if (!instance->casts) continue;
    const Mesh& mesh = *instance->mesh;
    for (size_t t = 0; t < mesh.indices().size(); t += 3) {
      DVec3 p[3];
      for (int k = 0; k < 3; ++k) {
        p[k] = DVec3(TransformPoint(instance->world_from_mesh,
                                    mesh.positions()[mesh.indices()[t + k]])) -
               from;
      }
      const double volume[3] = {glm::dot(direction, glm::cross(p[0], p[1])),
                                glm::dot(direction, glm::cross(p[1], p[2])),
                                glm::dot(direction, glm::cross(p[2], p[0]))};
      const double sum = volume[0] + volume[1] + volume[2];
      if (sum == 0) continue;
      const double least =
          std::min({std::abs(volume[0]), std::abs(volume[1]), std::abs(volume[2])});
      const DVec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
      const double distance = glm::dot(normal, p[0]) / glm::dot(normal, direction);
      if (distance < 1e-4 || (!sample.at_infinity && distance > 1)) continue;
      const bool inside = (volume[0] > 0) == (volume[1] > 0) && (volume[1] > 0) == (volume[2] > 0);
      if (least < 2e-4) grazing = true;
      blocked |= inside;
    }
  }
  return blocked;
}

// Compares every texel; those that some ray grazes may differ by as many rays.
void ExpectMatchesRays(const Scene& scene, const Artifact& artifact) {
  const SoftShadowTexture& texture = TextureOf(artifact);
  for (uint32_t j = 0; j < texture.receiver.height; ++j) {
    for (uint32_t i = 0; i < texture.receiver.width; ++i) {
      const DVec3 from(texture.receiver.TexelCenter(i, j));
      int visible = 0, doubtful = 0;
      for (const LightSample& sample : artifact.header.light_samples) {
        bool grazing = false;
        visible += !Blocked(scene, from, sample, grazing);
        doubtful += grazing;
      }
      ASSERT_NEAR(texture.visibility.At(i, j), visible, doubtful) << "texel " << i << ", " << j;
    }
  }
}

Affine Rotated(float angle, Vec3 position, Vec3 scale) {
  const float c = std::cos(angle), s = std::sin(angle);
  return Affine(scale.x * Vec3(c, 0.3f * s, -s), scale.y * Vec3(-0.2f * s, 1, 0.1f),
                scale.z * Vec3(s, 0, c), position);
}

SceneDelta RandomBoxes(int count, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-1, 1);
  SceneDelta delta;
  for (int b = 0; b < count; ++b) {
    const Vec3 position(2.5f * uniform(random), 1.0f + 0.9f * uniform(random),
                        2.5f * uniform(random));
    const Vec3 scale(0.3f + 0.25f * uniform(random), 0.3f, b % 3 == 0 ? -0.3f : 0.3f);
    delta.upsert_instances.push_back(
        {.id = "box" + std::to_string(b),
         .mesh = testing::MeshOf(testing::UnitBoxGeometry()),
         .world_from_mesh = Rotated(3 * uniform(random), position, scale)});
  }
  return delta;
}

TEST(SoftTexture, MatchesRaysForEveryKindOfLight) {
  const LightShape lights[] = {
      std::get<RectangleLight>(Ceiling().shape),
      DiskLight{.center = Vec3(0.5f, 3, 0), .normal = Vec3(0.3f, -1, 0), .radius = 0.7f},
      SphereLight{.center = Vec3(-1, 2.5f, 1), .radius = 0.4f},
      PointLight{.position = Vec3(0.3f, 3, 0.2f)},
      SpotLight{.position = Vec3(1, 3, -1)},
      DistantLight{.to_light = Vec3(0.4f, 1, 0.2f), .angular_diameter = 0.2f}};
  uint32_t seed = 1;
  for (const LightShape& shape : lights) {
    SceneDelta delta = RandomBoxes(6, seed++);
    delta.upsert_receivers = {Floor(41, 37)};
    delta.upsert_lights = {{.id = "light", .shape = shape}};
    const auto scene = SceneOf(delta);
    const auto artifact = Compute(*scene, {.samples = 16});
    ASSERT_TRUE(artifact.ok()) << artifact.status();
    ExpectMatchesRays(*scene, *artifact);
  }
}

TEST(SoftTexture, MatchesRaysWhenObjectsPassTheLight) {
  SceneDelta delta;
  // A tilted slab that starts at the floor and ends above the lamp, inside the pyramid.
  delta.upsert_instances = {
      {.id = "slab",
       .mesh = testing::MeshOf(testing::UnitBoxGeometry()),
       .world_from_mesh = Rotated(0.7f, Vec3(0.9f, 1.4f, 0), Vec3(0.2f, 1.6f, 0.8f))},
      {.id = "close",
       .mesh = testing::MeshOf(testing::UnitBoxGeometry()),
       .world_from_mesh = testing::Placed(Vec3(-0.4f, 1.97f, 0.1f), 0.02f)}};
  delta.upsert_receivers = {Floor(48, 48)};
  delta.upsert_lights = {Ceiling(2)};
  const auto scene = SceneOf(delta);
  const auto artifact = Compute(*scene, {.samples = 25});
  ASSERT_TRUE(artifact.ok());
  ExpectMatchesRays(*scene, *artifact);
}

TEST(SoftTexture, MatchesRaysFromBelowAndOnASkewPatch) {
  SceneDelta delta = RandomBoxes(5, 5);
  for (Instance& box : delta.upsert_instances) box.world_from_mesh[3].y -= 1;
  delta.upsert_lights = {Ceiling(-3)};
  Receiver skew{.id = "floor",
                .shape = Parallelogram{.origin = Vec3(-2, 0.1f, -2),
                                       .edge_u = Vec3(4, 0.4f, 0.5f),
                                       .edge_v = Vec3(1, -0.2f, 3)},
                .width = 33,
                .height = 65};
  delta.upsert_receivers = {skew};
  const auto scene = SceneOf(delta);
  const auto artifact = Compute(*scene, {.samples = 9});
  ASSERT_TRUE(artifact.ok());
  ExpectMatchesRays(*scene, *artifact);
}

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

TEST(SoftTexture, DefinesALightInTheReceiversPlane) {
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

TEST(SoftTexture, HandlesGridsOfOneTexelAndOfManyBands) {
  SceneDelta delta = RandomBoxes(6, 2);
  delta.upsert_lights = {Ceiling()};
  delta.upsert_receivers = {Floor(1, 1)};
  const auto tiny = Compute(*SceneOf(delta), {.samples = 64});
  ASSERT_TRUE(tiny.ok());
  ExpectMatchesRays(*SceneOf(delta), *tiny);

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
