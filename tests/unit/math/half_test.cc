#include "render/math/half.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace penumbra {
namespace {

// The value of a half by its definition, in double precision.
double ValueOf(uint16_t half) {
  const int exponent = (half >> 10) & 31, mantissa = half & 1023;
  const double sign = half & 0x8000 ? -1 : 1;
  if (exponent == 0) return sign * std::ldexp(mantissa, -24);
  return sign * std::ldexp(1024 + mantissa, exponent - 25);
}

bool IsNanHalf(uint32_t half) { return (half & 0x7fff) > 0x7c00; }
bool IsInfinite(uint32_t half) { return (half & 0x7fff) == 0x7c00; }

TEST(Half, EveryOneOfThemIsTheFloatItStandsForAndComesBack) {
  for (uint32_t bits = 0; bits < 65536; ++bits) {
    const auto half = static_cast<uint16_t>(bits);
    const float value = FloatFromHalf(half);
    if (IsNanHalf(bits)) {
      EXPECT_TRUE(std::isnan(value)) << bits;
      EXPECT_TRUE(IsNanHalf(HalfFromFloat(value))) << bits;
      continue;
    }
    if (IsInfinite(bits)) {
      EXPECT_TRUE(std::isinf(value)) << bits;
    } else {
      EXPECT_EQ(value, ValueOf(half)) << bits;
    }
    EXPECT_EQ(std::signbit(value), (bits & 0x8000) != 0) << bits;
    EXPECT_EQ(HalfFromFloat(value), half) << bits;
  }
}

// Between each two neighbours: to the even one from the middle, to the nearer one from beside it.
TEST(Half, RoundsToTheNearestAndTiesToEven) {
  for (uint32_t bits = 0; bits < 0x7bff; ++bits) {
    const auto low = static_cast<uint16_t>(bits), high = static_cast<uint16_t>(bits + 1);
    const auto middle = static_cast<float>(0.5 * (ValueOf(low) + ValueOf(high)));
    ASSERT_EQ(middle, 0.5 * (ValueOf(low) + ValueOf(high)));
    ASSERT_EQ(HalfFromFloat(middle), bits % 2 == 0 ? low : high) << bits;
    ASSERT_EQ(HalfFromFloat(std::nextafter(middle, 0.0f)), low) << bits;
    ASSERT_EQ(HalfFromFloat(std::nextafter(middle, 1e9f)), high) << bits;
    ASSERT_EQ(HalfFromFloat(-middle), 0x8000 | (bits % 2 == 0 ? low : high)) << bits;
  }
}

TEST(Half, EndsWhereFloatsGoOn) {
  EXPECT_EQ(FloatFromHalf(0x7bff), kLargestHalf);
  EXPECT_EQ(HalfFromFloat(std::nextafter(65520.0f, 0.0f)), 0x7bff);
  EXPECT_EQ(HalfFromFloat(65520.0f), 0x7c00);
  EXPECT_EQ(HalfFromFloat(65536.0f), 0x7c00);
  EXPECT_EQ(HalfFromFloat(std::numeric_limits<float>::max()), 0x7c00);
  EXPECT_EQ(HalfFromFloat(-std::numeric_limits<float>::infinity()), 0xfc00);
  EXPECT_EQ(HalfFromFloat(std::numeric_limits<float>::denorm_min()), 0);
  EXPECT_EQ(HalfFromFloat(-0.0f), 0x8000);
}

}  // namespace
}  // namespace penumbra
