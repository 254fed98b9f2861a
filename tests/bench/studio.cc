#include "tests/bench/studio.h"

#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "tests/support/shapes.h"

namespace penumbra::bench {
namespace {

constexpr float kFloorSide = 10;

}  // namespace

SceneDelta Studio(uint32_t texels) {
  SceneDelta delta;
  delta.upsert_receivers = {testing::FloorReceiver("floor", kFloorSide, texels)};
  delta.upsert_lights = {
      {.id = "lamp",
       .shape = RectangleLight{
           .corner = Vec3(-1, 8, -1), .edge_u = Vec3(2, 0, 0), .edge_v = Vec3(0, 0, 2)}}};
  return delta;
}

SceneDelta Boxes(int count, uint32_t texels) {
  SceneDelta delta = Studio(texels);
  std::mt19937 random(1997);
  std::uniform_real_distribution<float> uniform(0, 1);
  const auto box = testing::MeshOf(testing::UnitBoxGeometry());
  for (int i = 0; i < count; ++i) {
    const auto angle = [&] { return 2 * std::numbers::pi_v<float> * uniform(random); };
    const float a = angle(), b = angle(), size = 0.05f + 0.2f * uniform(random);
    const Vec3 x(std::cos(a), 0, std::sin(a));
    const Vec3 y = std::cos(b) * Vec3(0, 1, 0) + std::sin(b) * glm::cross(x, Vec3(0, 1, 0));
    const Vec3 place((uniform(random) - 0.5f) * kFloorSide, 0.3f + 5 * uniform(random),
                     (uniform(random) - 0.5f) * kFloorSide);
    delta.upsert_instances.push_back(
        {.id = "box" + std::to_string(i),
         .mesh = box,
         .world_from_mesh = Affine(size * x, size * y, size * glm::cross(x, y), place)});
  }
  return delta;
}

}  // namespace penumbra::bench
