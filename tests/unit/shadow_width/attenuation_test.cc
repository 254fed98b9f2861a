// The five properties that Kirsch and Döllner ask of the attenuation, on random pairs.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "render/artifact/shadow_width_map.h"

namespace penumbra {
namespace {

constexpr int kPairs = 1'000'000;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

class AttenuationTest : public ::testing::Test {
 protected:
  // From a thousandth to a thousand, and now and then 0.
  double Length() { return random_() % 16 == 0 ? 0 : std::exp(log_(random_)); }

  std::mt19937_64 random_{42};
  std::uniform_real_distribution<double> log_{std::log(1e-3), std::log(1e3)};
};

TEST_F(AttenuationTest, OneWhereTheLightIsSeen) {
  for (int i = 0; i < kPairs; ++i) {
    const double length = Length(), c_scale = Length(), c_bias = 0.1 * (random_() % 3);
    ASSERT_EQ(Attenuation(0, length, c_scale, c_bias), 1);
    ASSERT_EQ(Attenuation(length, 0, c_scale, c_bias), 1);
    ASSERT_EQ(Attenuation(-length, length, c_scale, c_bias), 1);
  }
}

TEST_F(AttenuationTest, DependsOnTheRatioAlone) {
  for (int i = 0; i < kPairs; ++i) {
    const double sd = Length(), sw = Length(), c_scale = Length(), factor = std::exp(log_(random_));
    const double here = Attenuation(sd, sw, c_scale, 0.05);
    ASSERT_NEAR(Attenuation(factor * sd, factor * sw, c_scale, 0.05), here, 1e-9 * (1 + c_scale));
  }
}

TEST_F(AttenuationTest, BrightensTowardsTheBoundary) {
  int strictly = 0;
  for (int i = 0; i < kPairs; ++i) {
    const double sd = Length(), c_scale = Length();
    double deep = Length(), shallow = Length();
    if (deep < shallow) std::swap(deep, shallow);
    const double at_shallow = Attenuation(sd, shallow, c_scale, 0);
    const double at_deep = Attenuation(sd, deep, c_scale, 0);
    ASSERT_LE(at_deep, at_shallow);
    if (!(at_shallow > 0) || !(deep > shallow) || !(sd > 0) || !(c_scale > 0)) continue;
    if (c_scale * (deep - shallow) / sd < 1e-15) continue;  // what a double can tell
    ASSERT_LT(at_deep, at_shallow) << sd << " " << shallow << " " << deep << " " << c_scale;
    ++strictly;
  }
  EXPECT_GT(strictly, kPairs / 10);
}

TEST_F(AttenuationTest, IsContinuous) {
  for (int i = 0; i < kPairs; ++i) {
    const double sd = std::exp(log_(random_)), sw = Length(), c_scale = Length();
    const double step = 1e-9 * sd;
    // No steeper than c_scale / sd along sw; from the lit side too, where sw is 0.
    ASSERT_NEAR(Attenuation(sd, sw + step, c_scale, 0), Attenuation(sd, sw, c_scale, 0),
                1e-8 * c_scale + 1e-12);
  }
}

TEST_F(AttenuationTest, SharpensWhereReceiverAndBlockerApproach) {
  int strictly = 0;
  for (int i = 0; i < kPairs; ++i) {
    const double sw = Length(), c_scale = Length();
    double near = std::exp(log_(random_)), far = std::exp(log_(random_));
    if (far < near) std::swap(far, near);
    const double at_near = Attenuation(near, sw, c_scale, 0);
    const double at_far = Attenuation(far, sw, c_scale, 0);
    ASSERT_LE(at_near, at_far);
    if (!(at_far > 0) || !(sw > 0) || !(c_scale > 0)) continue;
    if (c_scale * sw * (1 / near - 1 / far) < 1e-15) continue;
    ASSERT_LT(at_near, at_far);
    ++strictly;
  }
  EXPECT_GT(strictly, kPairs / 10);
}

TEST_F(AttenuationTest, StaysInRangeWhateverIsAsked) {
  const double numbers[] = {0, 1e-300, 1, 1e300, kInfinity, std::nan("")};
  for (const double sd : numbers) {
    for (const double sw : numbers) {
      for (const double c_scale : {0.0, 1.0, kInfinity}) {
        const double share = Attenuation(sd, sw, c_scale, 0);
        if (std::isnan(sd) || std::isnan(sw)) continue;
        EXPECT_TRUE(share >= 0 && share <= 1) << sd << " " << sw << " " << c_scale;
      }
    }
  }
}

}  // namespace
}  // namespace penumbra
