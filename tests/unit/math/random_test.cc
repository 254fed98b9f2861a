#include "render/math/random.h"

#include <gtest/gtest.h>

#include <cmath>

namespace penumbra {
namespace {

TEST(Random, IsUniformAndUncorrelated) {
  constexpr int kCount = 100'000;
  double sum = 0, squares = 0, product = 0;
  for (int i = 0; i < kCount; ++i) {
    const double x = UniformAt(1, i, 0), y = UniformAt(1, i, 1);
    ASSERT_GE(x, 0.0);
    ASSERT_LT(x, 1.0);
    sum += x;
    squares += x * x;
    product += (x - 0.5) * (y - 0.5);
  }
  // Five standard errors: mean 1/2 ± √(1/12n), mean square 1/3 ± √(4/45n), covariance 0 ± 1/(12√n).
  EXPECT_NEAR(sum / kCount, 0.5, 5 * std::sqrt(1.0 / 12 / kCount));
  EXPECT_NEAR(squares / kCount, 1.0 / 3, 5 * std::sqrt(4.0 / 45 / kCount));
  EXPECT_NEAR(product / kCount, 0.0, 5.0 / 12 / std::sqrt(kCount));
}

TEST(Random, IsAFunctionOfItsArguments) {
  EXPECT_EQ(UniformAt(3, 5, 1), UniformAt(3, 5, 1));
  EXPECT_NE(UniformAt(3, 5, 1), UniformAt(4, 5, 1));
  EXPECT_NE(UniformAt(3, 5, 1), UniformAt(3, 6, 1));
  EXPECT_NE(UniformAt(3, 5, 1), UniformAt(3, 5, 0));
}

}  // namespace
}  // namespace penumbra
