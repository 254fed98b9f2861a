// The interpolated form factor stays within its bound, whatever the light and the patch.
#include "render/artifact/unoccluded_texture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <vector>

#include "render/scene/unoccluded_light.h"
#include "tests/support/random_scene.h"

namespace penumbra::testing {
namespace {

// Below this part of the texture's largest factor an error counts in relation to that part: closed
// forms that cancel to almost nothing have no more digits.
constexpr double kDarkest = 1e-6;
constexpr double kFloatRounding = 4e-7;
// A light that lies in the patch's plane to within rounding gives no more than this.
constexpr double kNothing = 1e-9;

struct Pair {
  AreaLight light;
  ReceiverPatch receiver;
};

Vec3 AnyNormal(Dice& dice, Vec3 towards) {
  return dice.Below(3) == 0 ? towards : glm::normalize(towards + 1.5f * dice.Direction());
}

// Of 0.3 to 10 m, anywhere.
ReceiverPatch RandomPatch(Dice& dice) {
  const float side = dice.Between(0.3f, 10);
  const Vec3 u = dice.Direction();
  const Vec3 v = glm::normalize(glm::cross(u, dice.Direction())) + dice.Between(-0.5f, 0.5f) * u;
  return {.patch = {.origin = dice.InCube(3),
                    .edge_u = side * u,
                    .edge_v = side * dice.Between(0.3f, 1.5f) * v},
          .width = 20 + dice.Below(60),
          .height = 20 + dice.Below(60),
          .two_sided = dice.Below(2) == 0};
}

// A patch, and a light of some size at any height over it, touching or crossing its plane too.
Pair RandomPair(Dice& dice, int kind) {
  Pair pair{.light = {}, .receiver = RandomPatch(dice)};
  const Parallelogram& patch = pair.receiver.patch;
  const float side = glm::length(patch.edge_u);
  const Vec3 over = patch.At({dice.Between(-0.5f, 1.5f), dice.Between(-0.5f, 1.5f)});
  const float heights[] = {0.0f, 0.02f, 0.1f, 0.5f, 1.5f, 4.0f};
  const float height = side * heights[dice.Below(6)] * dice.Between(0.5f, 1.5f) *
                       (dice.Below(4) == 0 ? -1.0f : 1.0f);
  const Vec3 at = over + height * patch.normal();
  const float size = side * dice.Between(0.02f, 0.8f);
  const bool two_sided = dice.Below(2) == 0;
  const Vec3 down = AnyNormal(dice, -patch.normal());
  pair.light = RandomLight(dice, kind);
  if (auto* rectangle = std::get_if<RectangleLight>(&pair.light.shape)) {
    const Vec3 s = glm::normalize(glm::cross(down, dice.Direction()));
    rectangle->edge_u = size * s;
    rectangle->edge_v = size * dice.Between(0.2f, 1) * glm::cross(down, s) + 0.3f * size * s;
    rectangle->corner = at - 0.5f * (rectangle->edge_u + rectangle->edge_v);
    rectangle->two_sided = two_sided;
  } else if (auto* disk = std::get_if<DiskLight>(&pair.light.shape)) {
    *disk = {.center = at, .normal = down, .radius = 0.5f * size, .two_sided = two_sided};
  } else if (auto* sphere = std::get_if<SphereLight>(&pair.light.shape)) {
    *sphere = {.center = at, .radius = 0.5f * size};
  } else if (auto* point = std::get_if<PointLight>(&pair.light.shape)) {
    point->position = at;
  } else if (auto* spot = std::get_if<SpotLight>(&pair.light.shape)) {
    const float outer = dice.Between(0.05f, 1.5f);
    *spot = {at, down, spot->intensity, outer * dice.Between(0, 0.99f), outer};
  }
  return pair;
}

struct Worst {
  double error = 0;  // in relation to the closed form, rounding left aside
  bool is_lit = false;
};

Worst Compare(const Pair& pair, double bound) {
  const ReceiverPatch& receiver = pair.receiver;
  std::vector<float> factors(size_t{receiver.width} * receiver.height, -1.0f);
  UnoccludedTexture(pair.light, receiver, bound)
      .ForEachBlock({}, [&](const TexelBlock& block, std::span<const float> values) {
        for (uint32_t t = 0; t < block.width * block.height; ++t) {
          factors[size_t{block.y + t / block.width} * receiver.width + block.x + t % block.width] =
              values[t];
        }
      });
  std::vector<double> exact(factors.size());
  const DVec3 n =
      glm::normalize(glm::cross(DVec3(receiver.patch.edge_u), DVec3(receiver.patch.edge_v)));
  for (uint32_t t = 0; t < factors.size(); ++t) {
    const DVec3 point = DVec3(receiver.patch.origin) +
                        (t % receiver.width + 0.5) / receiver.width * DVec3(receiver.patch.edge_u) +
                        (t / receiver.width + 0.5) / receiver.height * DVec3(receiver.patch.edge_v);
    exact[t] = UnoccludedFactor(pair.light, point, n);
    if (receiver.two_sided) exact[t] += UnoccludedFactor(pair.light, point, -n);
  }
  const double largest = *std::max_element(exact.begin(), exact.end());
  if (largest < kNothing) return {};
  Worst worst{.is_lit = true};
  for (size_t t = 0; t < exact.size(); ++t) {
    const double error = std::abs(factors[t] - exact[t]) - kFloatRounding * exact[t];
    if (!(error > 0)) continue;
    worst.error = std::max(worst.error, error / std::max(exact[t], kDarkest * largest));
  }
  return worst;
}

class UnoccludedTextureTest : public ::testing::TestWithParam<int> {};

TEST_P(UnoccludedTextureTest, StaysWithinItsBound) {
  for (const double bound : {1e-4, 1e-3, 1e-2, 0.1}) {
    Dice dice(31 + GetParam());
    double worst = 0;
    int lit = 0;
    for (int trial = 0; trial < 170; ++trial) {
      const Pair pair = RandomPair(dice, GetParam());
      const Worst found = Compare(pair, bound);
      lit += found.is_lit;
      ASSERT_LE(found.error, bound) << "pair " << trial;
      worst = std::max(worst, found.error);
    }
    EXPECT_GT(lit, 60);
    std::cout << "bound " << bound << ": " << lit << " lit pairs, worst error " << worst << "\n";
  }
}

TEST_P(UnoccludedTextureTest, IsTheClosedFormWithoutABound) {
  Dice dice(77 + GetParam());
  for (int trial = 0; trial < 30; ++trial) {
    ASSERT_EQ(Compare(RandomPair(dice, GetParam()), 0).error, 0) << "pair " << trial;
  }
}

INSTANTIATE_TEST_SUITE_P(EveryLight, UnoccludedTextureTest, ::testing::Range(0, kLightKinds));

}  // namespace
}  // namespace penumbra::testing
