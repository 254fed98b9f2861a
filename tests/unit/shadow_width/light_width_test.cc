// How wide a light is, against the spread of shadows that its points cast.
#include "render/artifact/light_width.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "render/light_view/light_face.h"
#include "render/scene/light_sample.h"

namespace penumbra {
namespace {

constexpr int kEdges = 40;

// A ramp as wide as the standard deviation of what `value` gives for points of the light.
template <typename Value>
double WidthOfSpread(const AreaLight& light, Vec3 target, const Value& value) {
  double sum = 0, squares = 0, weights = 0;
  for (uint64_t seed = 0; seed < 8; ++seed) {
    for (const LightSample& sample : SampleLight(light, 1024, seed, target)) {
      const double x = value(sample);
      sum += sample.weight * x, squares += sample.weight * x * x, weights += sample.weight;
    }
  }
  const double mean = sum / weights;
  return std::sqrt(12 * (squares / weights - mean * mean));
}

// Shadows that a point far from the light casts on a plane further off, measured on the image: by
// rays, without the view's own formulas for shifts.
void ExpectWidths(const AreaLight& light, double tolerance) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  const Aabb bounds{.min = Vec3(-60, -60, -60), .max = Vec3(60, 60, 60)};
  for (const LightFace& face : FacesOf(light, bounds)) {
    const LightView view{.frame = face.frame,
                         .from_infinity = face.from_infinity,
                         .window = face.window,
                         .width = 64,
                         .height = 64};
    const LightWidth width(light, view);
    for (int i = 0; i < kEdges; ++i) {
      const DVec2 pixel(32 + 28 * unit(random), 32 + 28 * unit(random));
      const double angle = std::numbers::pi * unit(random);
      const DVec2 across(std::cos(angle), std::sin(angle));
      const double near = 20, far = 40;
      const DVec3 blocker = view.PointAt(pixel, near);
      const DVec2 scale = view.pixels_per_slope();
      const double found = WidthOfSpread(light, Vec3(blocker), [&](const LightSample& sample) {
        const DVec3 from(sample.point);
        const DVec3 way = sample.at_infinity ? -from : blocker - from;
        const double per_depth = 1 / glm::dot(way, face.frame.axes.n);
        const DVec3 shadow = blocker + (far - near) * per_depth * way;
        return glm::dot(DVec2(view.Project(shadow)) / scale, across);
      });
      const double nearness = face.from_infinity ? far - near : 1 / near - 1 / far;
      const DVec2 at = view.window.min + pixel / scale;
      EXPECT_NEAR(width.Along(at, across) * nearness / found, 1, tolerance)
          << "at " << at.x << " " << at.y << " across " << across.x << " " << across.y;
    }
  }
}

TEST(LightWidthTest, OfARectangle) {
  ExpectWidths({.id = "l",
                .shape = RectangleLight{.corner = {-0.2f, 1, 0.1f},
                                        .edge_u = {0.8f, 0, 0},
                                        .edge_v = {0.1f, 0.05f, 0.3f}}},
               0.05);
}

TEST(LightWidthTest, OfADisk) {
  ExpectWidths({.id = "l", .shape = DiskLight{.normal = {0.2f, -1, 0.3f}, .radius = 0.4f}}, 0.05);
}

// Of a sphere half is sampled, towards the blocker; what it hides of the light is as its disc does.
TEST(LightWidthTest, OfASphere) {
  ExpectWidths({.id = "l", .shape = SphereLight{.radius = 0.3f}}, 0.3);
}

TEST(LightWidthTest, OfTheSun) {
  ExpectWidths(
      {.id = "l", .shape = DistantLight{.to_light = {0.3f, 1, 0.2f}, .angular_diameter = 0.05f}},
      0.05);
}

TEST(LightWidthTest, PointsHaveNone) {
  const LightView view{.window = {.min = {-1, -1}, .max = {1, 1}}, .width = 8, .height = 8};
  for (const LightShape& shape : {LightShape(PointLight{}), LightShape(SpotLight{})}) {
    EXPECT_EQ(LightWidth({.id = "l", .shape = shape}, view).Along({0.3, 0.2}, {1, 0}), 0);
  }
}

TEST(LightWidthTest, WithoutADirectionItIsTheMean) {
  const AreaLight light{
      .id = "l",
      .shape = RectangleLight{.corner = {-2, 0, -0.5f}, .edge_u = {4, 0, 0}, .edge_v = {0, 0, 1}}};
  const LightView view{
      .frame = FacesOf(light, {.min = Vec3(-1, -9, -1), .max = Vec3(1, -8, 1)})[0].frame,
      .window = {.min = {-1, -1}, .max = {1, 1}},
      .width = 8,
      .height = 8};
  double squares = 0;
  for (int k = 0; k < 360; ++k) {
    const double angle = k * std::numbers::pi / 180;
    const double width = LightWidth(light, view).Along({0, 0}, {std::cos(angle), std::sin(angle)});
    squares += width * width / 360;
  }
  EXPECT_NEAR(LightWidth(light, view).Along({0, 0}, {0, 0}), std::sqrt(squares), 1e-9);
}

}  // namespace
}  // namespace penumbra
