#include "render/math/basis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace penumbra {
namespace {

DVec3 RandomVector(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return {normal(random), normal(random), normal(random)};
}

// Also of axes as close to the one direction that the formula cannot turn to as numbers can be.
TEST(Basis, IsOrthonormalAroundAnyAxis) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 20000; ++trial) {
    DVec3 axis = RandomVector(random);
    if (trial % 2) axis = DVec3(0, -1, 0) + std::pow(10.0, -trial / 800.0) * axis;
    const auto [s, t, n] = BasisAround(axis);
    ASSERT_NEAR(glm::length(n - glm::normalize(axis)), 0, 1e-15);
    for (const DVec3& unit : {s, t}) ASSERT_NEAR(glm::length(unit), 1, 1e-14) << trial;
    ASSERT_NEAR(glm::length(glm::cross(s, t) - n), 0, 1e-14) << trial;
  }
  for (const DVec3& axis : {DVec3(0, -1, 0), DVec3(0, 1, 0), DVec3(3, 0, 0)}) {
    const auto [s, t, n] = BasisAround(axis);
    EXPECT_EQ(glm::cross(s, t), n);
  }
}

// A basis turns by no more than its axis does, times the distance to where the jump is.
TEST(Basis, TurnsWithItsAxis) {
  std::mt19937 random(2);
  for (int trial = 0; trial < 20000; ++trial) {
    const DVec3 axis = glm::normalize(RandomVector(random));
    const DVec3 turned = glm::normalize(axis + 1e-6 * RandomVector(random));
    if (axis.y < -0.9) continue;
    const Basis before = BasisAround(axis), after = BasisAround(turned);
    const double angle = glm::length(turned - axis);
    ASSERT_LT(glm::length(after.s - before.s), 5 * angle) << trial;
    ASSERT_LT(glm::length(after.t - before.t), 5 * angle) << trial;
  }
}

}  // namespace
}  // namespace penumbra
