// Scenes for the tests of soft_texture: a floor under a lamp, and boxes between them.
#pragma once

#include <cmath>
#include <random>
#include <string>

#include "render/technique/technique.h"
#include "tbb/task_arena.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {

// A floor of `side` metres around the origin, facing up.
inline Receiver Floor(uint32_t width, uint32_t height, float side = 6) {
  return {.id = "floor",
          .shape = Parallelogram{.origin = Vec3(-side / 2, 0, side / 2),
                                 .edge_u = Vec3(side, 0, 0),
                                 .edge_v = Vec3(0, 0, -side)},
          .width = width,
          .height = height};
}

inline AreaLight Ceiling(float height = 4) {
  return {.id = "light",
          .shape = RectangleLight{
              .corner = Vec3(-1, height, -1), .edge_u = Vec3(2, 0, 0), .edge_v = Vec3(0, 0, 2)}};
}

inline std::shared_ptr<const Scene> SceneOf(SceneDelta delta) {
  return Scene::Empty("test")->Apply(delta).value();
}

inline absl::StatusOr<Artifact> Compute(const Scene& scene, SoftTextureParams params = {},
                                        int threads = 2) {
  tbb::task_arena arena(threads);
  const ArtifactSpec spec{.params = params, .light_id = "light", .receiver_id = "floor"};
  const ComputeContext context{
      .arena = arena, .gl = nullptr, .stop = {}, .progress = {}, .now_ms = {}};
  return TechniqueFor(spec.params).Compute(scene, spec, context);
}

inline const SoftShadowTexture& TextureOf(const Artifact& artifact) {
  return std::get<SoftShadowTexture>(artifact.payload);
}

inline Affine Rotated(float angle, Vec3 position, Vec3 scale) {
  const float c = std::cos(angle), s = std::sin(angle);
  return Affine(scale.x * Vec3(c, 0.3f * s, -s), scale.y * Vec3(-0.2f * s, 1, 0.1f),
                scale.z * Vec3(s, 0, c), position);
}

inline SceneDelta RandomBoxes(int count, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-1, 1);
  SceneDelta delta;
  for (int b = 0; b < count; ++b) {
    const Vec3 position(2.5f * uniform(random), 1.0f + 0.9f * uniform(random),
                        2.5f * uniform(random));
    const Vec3 scale(0.3f + 0.25f * uniform(random), 0.3f, b % 3 == 0 ? -0.3f : 0.3f);
    delta.upsert_instances.push_back(
        {.id = "box" + std::to_string(b),
         .mesh = MeshOf(UnitBoxGeometry()),
         .world_from_mesh = Rotated(3 * uniform(random), position, scale)});
  }
  return delta;
}

}  // namespace penumbra::testing
