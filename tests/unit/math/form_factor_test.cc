#include "render/math/form_factor.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "render/math/basis.h"

namespace penumbra {
namespace {

constexpr double kPi = std::numbers::pi;

// ∫ over the unit square, by the midpoint rule.
double Integrate(int steps, const std::function<double(double, double)>& f) {
  double sum = 0;
  for (int j = 0; j < steps; ++j) {
    for (int i = 0; i < steps; ++i) sum += f((i + 0.5) / steps, (j + 0.5) / steps);
  }
  return sum / steps / steps;
}

// The kernel of the form factor for the element of area at `y` with unit normal `m`.
double Kernel(DVec3 x, DVec3 n, DVec3 y, DVec3 m) {
  const DVec3 d = y - x;
  const double r2 = glm::dot(d, d);
  return std::max(0.0, glm::dot(n, d)) * std::abs(glm::dot(m, d)) / (kPi * r2 * r2);
}

double BruteForceParallelogram(DVec3 corner, DVec3 u, DVec3 v, DVec3 x, DVec3 n) {
  const DVec3 cross = glm::cross(u, v);
  const DVec3 m = glm::normalize(cross);
  return glm::length(cross) * Integrate(1000, [&](double s, double t) {
           return Kernel(x, n, corner + s * u + t * v, m);
         });
}

double BruteForceDisk(DVec3 center, DVec3 axis, double radius, DVec3 x, DVec3 n) {
  const DVec3 s = glm::normalize(glm::cross(axis, DVec3(0.31, 0.52, 0.79)));
  const DVec3 t = glm::cross(axis, s);
  return kPi * radius * radius * Integrate(1000, [&](double a, double b) {
           const double r = radius * std::sqrt(a), phi = 2 * kPi * b;
           return Kernel(x, n, center + r * (std::cos(phi) * s + std::sin(phi) * t), axis);
         });
}

// Σ cos θ / π over directions within α of the axis.
double BruteForceCap(double cos_to_axis, double alpha) {
  const DVec3 n(std::sqrt(1 - cos_to_axis * cos_to_axis), 0, cos_to_axis);
  return Integrate(1500,
                   [&](double a, double b) {
                     const double z = 1 - a * (1 - std::cos(alpha)), r = std::sqrt(1 - z * z),
                                  phi = 2 * kPi * b;
                     return std::max(0.0,
                                     glm::dot(n, DVec3(r * std::cos(phi), r * std::sin(phi), z)));
                   }) *
         2 * (1 - std::cos(alpha));
}

class FormFactorTest : public ::testing::Test {
 protected:
  DVec3 RandomVector() { return {uniform_(random_), uniform_(random_), uniform_(random_)}; }
  DVec3 RandomDirection() { return glm::normalize(RandomVector() + DVec3(1e-3)); }

  std::mt19937 random_{5};
  std::uniform_real_distribution<double> uniform_{-1, 1};
};

TEST_F(FormFactorTest, OfAParallelogramIsTheIntegral) {
  for (int trial = 0; trial < 25; ++trial) {
    const DVec3 corner = 2.0 * RandomVector() + DVec3(0, 0, 2.5), u = RandomVector(),
                v = RandomVector();
    const DVec3 n = RandomDirection();
    const std::array<DVec3, 4> polygon = {corner, corner + u, corner + u + v, corner + v};
    const double expected = BruteForceParallelogram(corner, u, v, DVec3(0), n);
    EXPECT_NEAR(PolygonFormFactor(polygon, DVec3(0), n), expected, 2e-4 * (0.05 + expected))
        << trial;
  }
}

// A textbook value: a square of side 2 at distance 1, seen from below its corner: F = Σ over both
// edges.
TEST_F(FormFactorTest, OfASquareOverItsCornerIsTheTextbookValue) {
  const double a = 2.0, c = a / std::sqrt(1 + a * a);
  const double expected = (c * std::atan(a / std::sqrt(1 + a * a))) / kPi;
  const std::array<DVec3, 4> square = {DVec3(0, 0, 1), DVec3(a, 0, 1), DVec3(a, a, 1),
                                       DVec3(0, a, 1)};
  EXPECT_NEAR(PolygonFormFactor(square, DVec3(0), DVec3(0, 0, 1)), expected, 1e-12);
}

TEST_F(FormFactorTest, DependsOnNeitherWindingNorStart) {
  const std::array<DVec3, 3> a = {DVec3(1, 0, 1), DVec3(0, 1, 2), DVec3(-1, -1, 1)};
  const std::array<DVec3, 3> b = {a[2], a[1], a[0]};
  EXPECT_DOUBLE_EQ(PolygonFormFactor(a, DVec3(0), DVec3(0, 0, 1)),
                   PolygonFormFactor(b, DVec3(0), DVec3(0, 0, 1)));
}

TEST_F(FormFactorTest, FillsTheHemisphereCloseToALargePolygon) {
  const std::array<DVec3, 4> wide = {DVec3(-1e4, -1e4, 1), DVec3(1e4, -1e4, 1), DVec3(1e4, 1e4, 1),
                                     DVec3(-1e4, 1e4, 1)};
  EXPECT_NEAR(PolygonFormFactor(wide, DVec3(0), DVec3(0, 0, 1)), 1.0, 1e-6);
  EXPECT_EQ(PolygonFormFactor(wide, DVec3(0), DVec3(0, 0, -1)), 0.0);
}

TEST_F(FormFactorTest, IsANumberOnTheShapeItself) {
  const std::array<DVec3, 4> square = {DVec3(0), DVec3(1, 0, 0), DVec3(1, 1, 0), DVec3(0, 1, 0)};
  for (const DVec3 point : {DVec3(0), DVec3(0.5, 0, 0), DVec3(0.5, 0.5, 0), DVec3(3, 0, 0)}) {
    for (const DVec3 n : {DVec3(0, 0, 1), DVec3(1, 0, 0)}) {
      const double f = PolygonFormFactor(square, point, n);
      EXPECT_TRUE(f >= 0 && f <= 1) << f;
    }
    const double f = DiskFormFactor(DVec3(0), DVec3(0, 0, 1), 0.5, point, DVec3(0, 0, 1));
    EXPECT_TRUE(f >= 0 && f <= 1) << f;
  }
}

TEST_F(FormFactorTest, OfADiskIsTheIntegral) {
  for (int trial = 0; trial < 25; ++trial) {
    const DVec3 center = 2.0 * RandomVector() + DVec3(0, 0, 2.5), axis = RandomDirection();
    const DVec3 n = RandomDirection();
    const double radius = 0.2 + 0.8 * std::abs(uniform_(random_));
    const double expected = BruteForceDisk(center, axis, radius, DVec3(0), n);
    EXPECT_NEAR(DiskFormFactor(center, axis, radius, DVec3(0), n), expected,
                3e-4 * (0.05 + expected))
        << trial;
  }
}

TEST_F(FormFactorTest, OfADiskOverheadIsTheTextbookValue) {
  // F = r² / (h² + r²).
  EXPECT_NEAR(DiskFormFactor(DVec3(0, 0, 2), DVec3(0, 0, 1), 1, DVec3(0), DVec3(0, 0, 1)), 1 / 5.0,
              1e-14);
}

// The rim of a disc in the horizon goes up and down through it by rounding alone.
TEST_F(FormFactorTest, OfADiskInTheHorizonIsNothing) {
  for (int trial = 0; trial < 20000; ++trial) {
    const DVec3 axis(glm::normalize(glm::vec3(RandomDirection())));
    const DVec3 n(glm::vec3(axis * 1.0000001));
    const DVec3 point = 5e6 * RandomVector();
    const DVec3 center = point + 3.0 * BasisAround(axis).s + 1e-9 * RandomVector();
    const double f = DiskFormFactor(center, axis, 1, point, n);
    ASSERT_TRUE(f >= 0 && f < 1e-5) << f;
  }
}

TEST_F(FormFactorTest, OfADiskAHairsBreadthBelowItsRimIsHalf) {
  const DVec3 n(1, 0, 0), axis(0, 0, 1);
  for (const double z : {1e-3, 1e-6, 1e-9, 1e-12}) {
    // Half of what the disc seen from its rim covers is on the side of n.
    EXPECT_NEAR(DiskFormFactor(DVec3(1, 0, z), axis, 1, DVec3(0), DVec3(0, 0, 1)), 0.5, 2 * z) << z;
    EXPECT_TRUE(std::isfinite(DiskFormFactor(DVec3(1, 0, z), axis, 1, DVec3(0), n)));
  }
}

TEST_F(FormFactorTest, OfADistantDiskKeepsItsDigits) {
  // π r² cos θ cos θ' / (π d²), with d a million radii.
  const DVec3 center(3e6, 0, 4e6), n(0, 0, 1), axis(0, 0, 1);
  const double expected = 0.8 * 0.8 / 25e12;
  EXPECT_NEAR(DiskFormFactor(center, axis, 1, DVec3(0), n) / expected, 1.0, 1e-9);
}

TEST_F(FormFactorTest, OfACapIsTheIntegral) {
  for (const double alpha : {0.05, 0.4, 1.0, 1.5}) {
    for (const double c : {-0.99, -0.6, -0.2, -0.01, 0.0, 0.03, 0.3, 0.7, 0.999}) {
      const double s = std::sin(alpha);
      const double expected = BruteForceCap(c, alpha);
      EXPECT_NEAR(CapFormFactor(c, s * s), expected, 2e-4 * (0.01 + expected)) << alpha << " " << c;
    }
  }
}

TEST_F(FormFactorTest, OfACapIsContinuousAtTheHorizon) {
  const double sin2 = 0.09;
  for (const double c : {-0.3, 0.3}) {
    EXPECT_NEAR(CapFormFactor(c - 1e-9, sin2), CapFormFactor(c + 1e-9, sin2), 1e-8);
  }
}

}  // namespace
}  // namespace penumbra
