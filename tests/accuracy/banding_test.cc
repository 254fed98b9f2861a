// Steps in penumbrae: how fast they vanish with more samples, for every kind of light that has a
// size.
#include <array>
#include <string>
#include <utility>

#include "gtest/gtest.h"
#include "tests/accuracy/ledger.h"
#include "tests/support/penumbra_error.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

// A box and a board turned askew over a floor, with wide penumbrae.
std::shared_ptr<const Scene> StudioUnder(LightShape light) {
  const auto box = MeshOf(UnitBoxGeometry());
  const Affine board(Vec3(0.9f, 0.1f, 0.3f), Vec3(0, 0.03f, 0), Vec3(-0.1f, 0.1f, 0.6f),
                     Vec3(1.2f, 1.0f, 0.4f));
  SceneDelta delta;
  delta.upsert_instances = {
      {.id = "box", .mesh = box, .world_from_mesh = Placed(Vec3(-0.8f, 0.6f, -0.3f), 0.5f)},
      {.id = "board", .mesh = box, .world_from_mesh = board}};
  delta.upsert_receivers = {FloorReceiver("receiver", 6, 128)};
  delta.upsert_lights = {{.id = "light", .shape = light}};
  return Scene::Empty("s")->Apply(delta).value();
}

// An independent sample at each texel would give −0.5.
TEST(BandingTest, ErrorsFallFasterThanTheSquareRootOfTheSamples) {
  const std::array<std::pair<const char*, LightShape>, 4> lights = {{
      {"rectangle", RectangleLight{.corner = Vec3(-0.5f, 4, -0.7f),
                                   .edge_u = Vec3(1.2f, 0.2f, 0),
                                   .edge_v = Vec3(0, 0, 1.3f)}},
      {"disk", DiskLight{.center = Vec3(0.3f, 4, 0), .normal = Vec3(0.1f, -1, 0), .radius = 0.7f}},
      {"sphere", SphereLight{.center = Vec3(-0.2f, 4, 0.3f), .radius = 0.7f}},
      {"distant", DistantLight{.to_light = Vec3(0.2f, 1, 0.1f), .angular_diameter = 0.3f}},
  }};
  constexpr std::array<uint32_t, 3> kCounts = {16, 64, 256};
  for (const auto& [name, light] : lights) {
    const auto errors = PenumbraErrors(*StudioUnder(light), kCounts, 8);
    EXPECT_LE(FittedExponent(errors), -0.7) << name;
    ExpectInLedger(std::string("banding.") + name + ".rmse_of_64", errors[1].rmse);
  }
}

}  // namespace
}  // namespace penumbra::testing
