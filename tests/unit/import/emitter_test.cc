#include "client/import/emitter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace penumbra {
namespace {

Instance Make(std::vector<Vec3> positions, std::vector<uint32_t> indices) {
  return {
      .id = "e",
      .mesh =
          Mesh::Create({.positions = std::move(positions), .indices = std::move(indices)}).value()};
}

// A ball of `rings` × 2·`rings` quads about `center`; the last `skip` rings are left out.
Instance Ball(Vec3 center, float radius, int rings, int skip = 0) {
  std::vector<Vec3> positions;
  std::vector<uint32_t> indices;
  const int segments = 2 * rings;
  for (int i = 0; i <= rings; ++i) {
    for (int j = 0; j <= segments; ++j) {
      const float theta = std::numbers::pi_v<float> * float(i) / float(rings);
      const float phi = 2 * std::numbers::pi_v<float> * float(j) / float(segments);
      positions.push_back(center + radius * Vec3(std::sin(theta) * std::cos(phi), std::cos(theta),
                                                 std::sin(theta) * std::sin(phi)));
    }
  }
  for (int i = 0; i < rings - skip; ++i) {
    for (int j = 0; j < segments; ++j) {
      const uint32_t a = uint32_t(i * (segments + 1) + j), b = a + uint32_t(segments) + 1;
      indices.insert(indices.end(), {a, a + 1, b, a + 1, b + 1, b});
    }
  }
  return Make(positions, indices);
}

TEST(Emitter, AGridOfTrianglesThatFillsAParallelogramIsOneRectangle) {
  // A sheared 2×1 patch in four triangles.
  const Instance patch =
      Make({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0.5, 1, 0}, {1.5, 1, 0}, {2.5, 1, 0}},
           {0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4});
  const auto shape = EmitterShape(patch, Vec3(1), false);
  ASSERT_TRUE(shape.has_value());
  const auto light = std::get<RectangleLight>(*shape);
  EXPECT_NEAR(glm::length(glm::cross(light.edge_u, light.edge_v)), 2.0f, 1e-5f);
}

TEST(Emitter, AHoleOrAnOverlapIsNone) {
  // Half of the square.
  EXPECT_FALSE(EmitterShape(Make({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}, {0, 1, 2}), Vec3(1), false));
  // The square twice.
  EXPECT_FALSE(EmitterShape(
      Make({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {0, 1, 2, 0, 2, 3, 0, 1, 2, 0, 2, 3}),
      Vec3(1), false));
}

TEST(Emitter, ABallIsASphereWhereverItLies) {
  Instance ball = Ball({1, 2, 3}, 0.5f, 12);
  ball.world_from_mesh[3] = {10, 0, 0};
  const auto shape = EmitterShape(ball, Vec3(7), false);
  ASSERT_TRUE(shape.has_value());
  const auto light = std::get<SphereLight>(*shape);
  EXPECT_LT(glm::distance(light.center, Vec3(11, 2, 3)), 1e-5f);
  EXPECT_NEAR(light.radius, 0.5f, 1e-5f);
  EXPECT_EQ(light.radiance, Vec3(7));
}

TEST(Emitter, DomesEggsAndBoxesAreNone) {
  EXPECT_FALSE(EmitterShape(Ball({0, 0, 0}, 1, 12, 6), Vec3(1), false));
  Instance egg = Ball({0, 0, 0}, 1, 12);
  egg.world_from_mesh[1] *= 1.2f;
  EXPECT_FALSE(EmitterShape(egg, Vec3(1), false));
  EXPECT_FALSE(EmitterShape(Ball({0, 0, 0}, 1, 2), Vec3(1), false));
  EXPECT_FALSE(EmitterShape(Make({}, {}), Vec3(1), false));
}

}  // namespace
}  // namespace penumbra
