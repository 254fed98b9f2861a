#include "render/scene/unoccluded_light.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace penumbra {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;
const Vec3 kUp(0, 1, 0);

float Red(const LightShape& shape, Vec3 point = Vec3(0), Vec3 normal = kUp) {
  return UnoccludedRadiance({.id = "l", .shape = shape}, point, normal).x;
}

// A light of area A at distance d overhead, small against d, adds L A / (π d²).
TEST(UnoccludedRadiance, FallsWithTheSquareOfTheDistance) {
  const RectangleLight small{.corner = Vec3(-0.01f, 3, -0.01f),
                             .edge_u = Vec3(0.02f, 0, 0),
                             .edge_v = Vec3(0, 0, 0.02f),
                             .radiance = Vec3(7)};
  EXPECT_NEAR(Red(small), 7 * 0.0004f / (kPi * 9), 1e-8f);
  EXPECT_NEAR(Red(PointLight{.position = Vec3(0, 3, 0), .intensity = Vec3(7)}), 7 / (kPi * 9),
              1e-6f);
  EXPECT_NEAR(Red(DistantLight{.to_light = Vec3(0, 5, 0), .irradiance = Vec3(7)}), 7 / kPi, 1e-6f);
  EXPECT_NEAR(Red(SphereLight{.center = Vec3(0, 3, 0), .radius = 0.5f, .radiance = Vec3(7)}),
              7 * 0.25f / 9, 1e-6f);
}

TEST(UnoccludedRadiance, FallsWithTheCosine) {
  const Vec3 tilted(std::sin(0.7f), std::cos(0.7f), 0);
  for (const LightShape& light :
       {LightShape(PointLight{.position = Vec3(0, 3, 0)}), LightShape(DistantLight{}),
        LightShape(SphereLight{.center = Vec3(0, 3, 0)})}) {
    EXPECT_NEAR(Red(light, Vec3(0), tilted), Red(light) * std::cos(0.7f), 1e-6f);
  }
}

TEST(UnoccludedRadiance, ComesFromTheLitSideOnly) {
  RectangleLight up{.corner = Vec3(-1, 2, -1),
                    .edge_u = Vec3(0, 0, 2),
                    .edge_v = Vec3(2, 0, 0),
                    .radiance = Vec3(1),
                    .two_sided = false};  // front +y, away from the floor
  EXPECT_EQ(Red(up), 0);
  EXPECT_GT(Red(up, Vec3(0, 4, 0), -kUp), 0);
  up.two_sided = true;
  EXPECT_GT(Red(up), 0);
  DiskLight down{
      .center = Vec3(0, 2, 0), .normal = Vec3(0, -1, 0), .radiance = Vec3(1), .two_sided = false};
  EXPECT_GT(Red(down), 0);
  down.normal = kUp;
  EXPECT_EQ(Red(down), 0);
}

TEST(UnoccludedRadiance, HasTheSpotsCone) {
  const SpotLight spot{.position = Vec3(0, 1, 0),
                       .direction = Vec3(0, -1, 0),
                       .intensity = Vec3(kPi),
                       .inner_angle = 0.3f,
                       .outer_angle = 0.6f};
  const auto relative = [&](float angle) {
    const Vec3 point(std::tan(angle), 0, 0);
    return Red(spot, point) /
           Red(PointLight{.position = spot.position, .intensity = Vec3(kPi)}, point);
  };
  EXPECT_NEAR(relative(0.0f), 1, 1e-6);
  EXPECT_NEAR(relative(0.29f), 1, 1e-6);
  EXPECT_NEAR(relative(0.61f), 0, 1e-6);
  const double ramp = (std::cos(0.45) - std::cos(0.6)) / (std::cos(0.3) - std::cos(0.6));
  EXPECT_NEAR(relative(0.45f), ramp * ramp, 1e-5);
}

// The sun's radiance times the form factor of its disc is the same for every diameter as long as it
// is up.
TEST(UnoccludedRadiance, KeepsTheSunsIrradianceWhateverItsSize) {
  for (const float diameter : {0.0f, 1e-5f, 0.00925f, 0.5f, 1.5f}) {
    EXPECT_NEAR(Red(DistantLight{.to_light = Vec3(0.3f, 1, 0), .angular_diameter = diameter}),
                std::cos(std::atan(0.3f)) / kPi, 1e-6f)
        << diameter;
  }
}

TEST(UnoccludedRadiance, IsFiniteOnTheLight) {
  for (const LightShape& light :
       {LightShape(RectangleLight{}), LightShape(DiskLight{}), LightShape(SphereLight{}),
        LightShape(PointLight{}), LightShape(SpotLight{}), LightShape(DistantLight{})}) {
    for (const Vec3 point : {Vec3(0), Vec3(0.5f, 0, 0), Vec3(1, 0, 0)}) {
      for (const Vec3 normal : {kUp, -kUp, Vec3(1, 0, 0)}) {
        const float radiance = Red(light, point, normal);
        EXPECT_TRUE(std::isfinite(radiance) && radiance >= 0) << radiance;
      }
    }
  }
}

}  // namespace
}  // namespace penumbra
