// The oracle against textbook configurations.
#include "render/reference/light_integral.h"

#include <numbers>

#include "gtest/gtest.h"
#include "render/reference/adaptive_integral.h"

namespace penumbra {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr DVec3 kUp(0, 1, 0), kHere(0, 0, 0);

double Red(const LightShape& shape, DVec3 point, DVec3 normal) {
  return IntegratedRadiance({"light", shape}, point, normal).x;
}

TEST(AdaptiveIntegralTest, KnownIntegrals) {
  EXPECT_NEAR(AdaptiveIntegral([](double x) { return std::exp(x); }, 0, 1, 1e-12), std::exp(1) - 1,
              1e-12);
  EXPECT_NEAR(AdaptiveIntegral([](double x) { return 1 / (1e-4 + x * x); }, -1, 1, 1e-10),
              200 * std::atan(100), 1e-7);
}

TEST(LightIntegralTest, DiskOverhead) {
  const DiskLight disk{
      .center = Vec3(0, 2, 0), .normal = Vec3(0, -1, 0), .radius = 1.5f, .radiance = Vec3(3.0f)};
  EXPECT_NEAR(Red(disk, kHere, kUp), 3 * 1.5 * 1.5 / (1.5 * 1.5 + 2 * 2), 1e-8);
}

TEST(LightIntegralTest, HalfTheDiskIsBelowTheHorizon) {
  const DiskLight disk{.center = Vec3(2, 0, 0), .normal = Vec3(-1, 0, 0), .radius = 1.0f};
  // An element perpendicular to a disk on whose axis it lies: by symmetry, half of what both sides
  // see.
  const double x = 0.5;  // radius / distance
  const double expected = (std::atan(x) - x / (1 + x * x)) / kPi;
  EXPECT_NEAR(Red(disk, kHere, kUp), expected, 1e-8);
}

TEST(LightIntegralTest, RectangleOverACorner) {
  const RectangleLight light{
      .corner = Vec3(0, 1, 0), .edge_u = Vec3(2, 0, 0), .edge_v = Vec3(0, 0, 3)};
  const double a = 2, b = 3;  // sides over distance
  const double expected = (a / std::sqrt(1 + a * a) * std::atan(b / std::sqrt(1 + a * a)) +
                           b / std::sqrt(1 + b * b) * std::atan(a / std::sqrt(1 + b * b))) /
                          (2 * kPi);
  EXPECT_NEAR(Red(light, kHere, kUp), expected, 1e-8);
}

TEST(LightIntegralTest, OneSidedLightsShineToTheFront) {
  RectangleLight light{.corner = Vec3(-1, 1, -1),
                       .edge_u = Vec3(2, 0, 0),
                       .edge_v = Vec3(0, 0, 2),
                       .two_sided = false};
  EXPECT_GT(Red(light, kHere, kUp), 0.1);  // u × v points down
  std::swap(light.edge_u, light.edge_v);
  EXPECT_EQ(Red(light, kHere, kUp), 0);
}

TEST(LightIntegralTest, SphereActsAsFromItsCentre) {
  const SphereLight sphere{.center = Vec3(1, 3, 0), .radius = 0.5f, .radiance = Vec3(2.0f)};
  const double d2 = 10, cosine = 3 / std::sqrt(10);
  EXPECT_NEAR(Red(sphere, kHere, kUp), 2 * cosine * 0.25 / d2, 1e-8);
}

TEST(LightIntegralTest, LightsWithoutArea) {
  const PointLight point{.position = Vec3(0, 2, 0), .intensity = Vec3(5.0f)};
  EXPECT_NEAR(Red(point, kHere, kUp), 5 / (4 * kPi), 1e-12);
  EXPECT_EQ(Red(point, kHere, -kUp), 0);
  const DistantLight sun{
      .to_light = Vec3(0, 1, 1), .angular_diameter = 0.5f, .irradiance = Vec3(7.0f)};
  EXPECT_NEAR(Red(sun, kHere, kUp), 7 * std::sqrt(0.5) / kPi, 1e-8) << "a disc of any size";
  const SpotLight spot{.position = Vec3(0, 2, 0),
                       .direction = Vec3(0, -1, 0),
                       .inner_angle = 0.2f,
                       .outer_angle = 0.4f};
  EXPECT_NEAR(Red(spot, DVec3(0.2, 0, 0), kUp),
              Red(PointLight{.position = Vec3(0, 2, 0)}, DVec3(0.2, 0, 0), kUp), 1e-12);
  EXPECT_EQ(Red(spot, DVec3(1, 0, 0), kUp), 0);
}

}  // namespace
}  // namespace penumbra
