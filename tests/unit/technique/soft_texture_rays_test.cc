// soft_texture against rays in double precision, one by one.

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/technique/soft_texture_scenes.h"

namespace penumbra {
namespace {

using testing::Ceiling;
using testing::Compute;
using testing::Floor;
using testing::RandomBoxes;
using testing::Rotated;
using testing::SceneOf;
using testing::TextureOf;

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

TEST(SoftTexture, MatchesRaysOnAGridOfOneTexel) {
  SceneDelta delta = RandomBoxes(6, 2);
  delta.upsert_lights = {Ceiling()};
  delta.upsert_receivers = {Floor(1, 1)};
  const auto scene = SceneOf(delta);
  const auto artifact = Compute(*scene, {.samples = 64});
  ASSERT_TRUE(artifact.ok());
  ExpectMatchesRays(*scene, *artifact);
}

}  // namespace
}  // namespace penumbra
