// Attenuation LDIs against penumbrae known in closed form.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "render/artifact/attenuation_ldi.h"
#include "tests/unit/layered_attenuation/ldi_of.h"

namespace penumbra {
namespace {

using testing::Deviation;
using testing::LdiOf;
using testing::SceneOf;
using testing::Sheet;

constexpr Vec3 kUp{0, 1, 0};
constexpr float kLightHeight = 4, kSheetHeight = 1;

// 1 m square, `height` over the middle, its front down.
AreaLight Lamp(float height = kLightHeight, float side = 1, bool two_sided = false) {
  return {.id = "lamp",
          .shape = RectangleLight{.corner = {-0.5f * side, height, -0.5f * side},
                                  .edge_u = {side, 0, 0},
                                  .edge_v = {0, 0, side},
                                  .two_sided = two_sided}};
}

// What is left of a light `side` wide over a sheet that covers x < 0: its part beyond the plane
// through the point and the sheet's edge.
double BesideSheet(float x, double side, double light_height, double sheet_height) {
  const double edge = x * (1 - light_height / sheet_height);
  return std::clamp((0.5 * side - edge) / side, 0.0, 1.0);
}

TEST(ClosedFormTest, PenumbraBesideAHalfPlane) {
  const auto scene = SceneOf({Sheet({0, 0, 0}, 3, 3), Sheet({-1.5f, kSheetHeight, 0}, 1.5f, 3)});
  const AttenuationLdi ldi = LdiOf(*scene, Lamp());
  Deviation off;
  for (float x = -0.4f; x <= 0.4f; x += 0.0037f) {
    for (const float z : {-0.5f, 0.013f, 0.71f}) {
      off.Add(Visibility(ldi, Vec3(x, 0, z), kUp), BesideSheet(x, 1, kLightHeight, kSheetHeight));
    }
  }
  EXPECT_GT(off.partly_lit(), 150);
  EXPECT_LT(off.mean(), 0.012);
  EXPECT_LT(off.most(), 0.08);
  EXPECT_EQ(Visibility(ldi, Vec3(-1, kSheetHeight, 0), kUp), 1);
  EXPECT_EQ(Visibility(ldi, Vec3(-1, kSheetHeight, 0), -kUp), 0) << "its underside";
  EXPECT_EQ(Visibility(ldi, Vec3(-2, 0, 0), kUp), 0);
  EXPECT_EQ(Visibility(ldi, Vec3(2, 0, 0), kUp), 1);
}

// The part that two discs of radii `a` and `b`, `d` apart, have in common, of the area of `a`.
double SharedPart(double a, double b, double d) {
  if (d >= a + b) return 0;
  if (d <= std::abs(a - b)) return std::min(1.0, b * b / (a * a));
  const double of_a = std::acos((d * d + a * a - b * b) / (2 * d * a));
  const double of_b = std::acos((d * d + b * b - a * a) / (2 * d * b));
  const double lens =
      a * a * (of_a - 0.5 * std::sin(2 * of_a)) + b * b * (of_b - 0.5 * std::sin(2 * of_b));
  return lens / (std::numbers::pi * a * a);
}

MeshGeometry DiscGeometry(int corners) {
  MeshGeometry disc{.positions = {Vec3(0)}};
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners;
    disc.positions.emplace_back(std::cos(angle), 0, std::sin(angle));
    disc.indices.insert(disc.indices.end(), {0u, 1u + static_cast<uint32_t>(i),
                                             1u + static_cast<uint32_t>((i + 1) % corners)});
  }
  return disc;
}

TEST(ClosedFormTest, PenumbraBelowADiscUnderADiskLight) {
  constexpr double kRadius = 0.25, kLightRadius = 0.5;
  const auto scene =
      SceneOf({Sheet({0, 0, 0}, 3, 3),
               testing::Placed(DiscGeometry(256), testing::Placed({0, kSheetHeight, 0}, kRadius))});
  const AreaLight light{.id = "disk",
                        .shape = DiskLight{.center = {0, kLightHeight, 0}, .radius = kLightRadius}};
  const AttenuationLdi ldi = LdiOf(*scene, light);
  constexpr double kGrow = kLightHeight / kSheetHeight;  // of what the disc is on the light
  Deviation off;
  for (float x = 0; x <= 0.8f; x += 0.004f) {
    for (const float turn : {0.0f, 0.7f, 2.0f}) {
      const Vec3 p = x * Vec3(std::cos(turn), 0, std::sin(turn));
      off.Add(Visibility(ldi, p, kUp),
              1 - SharedPart(kLightRadius, kRadius * kGrow, x * (kGrow - 1)));
    }
  }
  EXPECT_GT(off.partly_lit(), 150);
  EXPECT_LT(off.mean(), 0.012);
  EXPECT_LT(off.most(), 0.08);
}

TEST(ClosedFormTest, PenumbraInTheSun) {
  const double radius = 0.05;
  const AreaLight sun{
      .id = "sun",
      .shape = DistantLight{.to_light = kUp, .angular_diameter = static_cast<float>(2 * radius)}};
  const auto scene = SceneOf({Sheet({0, 0, 0}, 3, 3), Sheet({-1.5f, 2, 0}, 1.5f, 3)});
  const AttenuationLdi ldi = LdiOf(*scene, sun, {.samples = 256, .resolution = 512});
  ASSERT_EQ(ldi.faces.size(), 1u);
  Deviation off;
  for (float x = -0.2f; x <= 0.2f; x += 0.0023f) {
    // The circle's part to one side of a line.
    const double d = std::clamp(x / (2 * std::tan(radius)), -1.0, 1.0);
    const double part = 1 - (std::acos(d) - d * std::sqrt(1 - d * d)) / std::numbers::pi;
    off.Add(Visibility(ldi, Vec3(x, 0, 0.3f), kUp), part);
  }
  EXPECT_GT(off.partly_lit(), 50);
  EXPECT_LT(off.mean(), 0.02);
  EXPECT_LT(off.most(), 0.09);
}

TEST(ClosedFormTest, NothingInBetweenIsOneToTheVeryEdge) {
  const auto scene = SceneOf({Sheet({0, 0, 0}, 1, 2)});
  for (const float height : {0.5f, 3.0f}) {
    const AttenuationLdi ldi = LdiOf(*scene, Lamp(height), {.samples = 32, .resolution = 256});
    EXPECT_EQ(ldi.faces.size(), height < 1 ? 5u : 1u);
    for (float x = -1; x <= 1; x += 0.05f) {
      for (float z = -2; z <= 2; z += 0.1f) {
        EXPECT_EQ(Visibility(ldi, Vec3(x, 0, z), kUp), 1) << height << ": " << x << ' ' << z;
      }
    }
    EXPECT_EQ(Visibility(ldi, Vec3(50, 0, 0), kUp), 1) << "outside of all windows";
    EXPECT_EQ(Visibility(ldi, Vec3(0, 0.2f, 0), kUp), 1) << "before everything";
  }
}

TEST(ClosedFormTest, AScreenBeforeAllOfItIsNought) {
  const auto scene = SceneOf({Sheet({0, 0, 0}, 1, 2), Sheet({0, 2, 0}, 3, 3)});
  const AttenuationLdi ldi = LdiOf(*scene, Lamp());
  for (float x = -1; x <= 1; x += 0.05f) {
    for (float z = -2; z <= 2; z += 0.1f) EXPECT_EQ(Visibility(ldi, Vec3(x, 0, z), kUp), 0);
  }
}

TEST(ClosedFormTest, ALightWithoutASizeCastsHardShadows) {
  const auto scene = SceneOf({Sheet({0, 0, 0}, 3, 3), Sheet({0, 1, 0}, 0.5f, 0.5f)});
  const AreaLight point{.id = "p", .shape = PointLight{.position = {0, kLightHeight, 0}}};
  for (const AreaLight& light : {point, Lamp(kLightHeight, 1e-5f)}) {
    const AttenuationLdi ldi = LdiOf(*scene, light, {.samples = 16, .resolution = 512});
    const float edge = 0.5f * kLightHeight / (kLightHeight - 1), pixel = 6.0f / 512;
    for (float x = 0; x < 1.5f; x += 0.01f) {
      if (std::abs(x - edge) < 2 * pixel) continue;
      EXPECT_EQ(Visibility(ldi, Vec3(x, 0, 0.1f), kUp), x < edge ? 0 : 1) << x;
    }
  }
}

// A lamp between a floor and a ceiling, each with a sheet before it.
TEST(ClosedFormTest, ALightShinesFromBothSidesOrFromItsFrontAlone) {
  const auto scene = SceneOf({Sheet({0, -4, 0}, 3, 3), Sheet({-1.5f, -3, 0}, 1.5f, 3),
                              Sheet({0, 4, 0}, 3, 3), Sheet({-1.5f, 3, 0}, 1.5f, 3)});
  for (const bool two_sided : {false, true}) {
    const AttenuationLdi ldi =
        LdiOf(*scene, Lamp(0, 1, two_sided), {.samples = 100, .resolution = 256});
    Deviation floor, ceiling;
    for (float x = -0.4f; x <= 0.4f; x += 0.0037f) {
      const double expected = BesideSheet(x, 1, 4, 1);
      floor.Add(Visibility(ldi, Vec3(x, -4, 0.2f), kUp), expected);
      ceiling.Add(Visibility(ldi, Vec3(x, 4, 0.2f), -kUp), two_sided ? expected : 0);
    }
    EXPECT_LT(floor.mean(), 0.015);
    EXPECT_LT(ceiling.mean(), 0.015);
    EXPECT_EQ(Visibility(ldi, Vec3(2, 4, 0), -kUp), two_sided ? 1 : 0);
  }
}

}  // namespace
}  // namespace penumbra
