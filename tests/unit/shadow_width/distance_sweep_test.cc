// The paper's sweeps: against trying all lit texels, and on which side of the exact distance they
// err.
#include "render/technique/shadow_width/distance_sweep.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "render/technique/shadow_width/distance_exact.h"
#include "tbb/global_control.h"
#include "tests/unit/shadow_width/distance_masks.h"

namespace penumbra {
namespace {

using testing::Dice;
using ::testing::Each;
using testing::OwnedMask;
using testing::RandomMask;

// A float's rounding, and that of √2 to 2⁻¹⁶ of a texel.
constexpr double kRounding = 2e-6;

class DistanceSweepTest : public ::testing::TestWithParam<SweepNeighbours> {
 protected:
  std::vector<float> Distances(const OwnedMask& mask, int threads = 2) {
    tbb::task_arena arena(threads);
    return DistanceBySweeps(mask.View(), GetParam(), arena, {}).value();
  }

  double Way(int64_t dx, int64_t dy) const {
    const double longer = static_cast<double>(std::max(std::abs(dx), std::abs(dy)));
    const double shorter = static_cast<double>(std::min(std::abs(dx), std::abs(dy)));
    if (GetParam() == SweepNeighbours::kFour) return longer + shorter;
    return longer - shorter + std::sqrt(2.0) * shorter;
  }
};

TEST_P(DistanceSweepTest, IsTheShortestWayFromNeighbourToNeighbour) {
  Dice dice(1);
  for (int trial = 0; trial < 300; ++trial) {
    const OwnedMask mask = RandomMask(dice, 1 + dice.Below(24), 1 + dice.Below(24));
    const std::vector<float> distances = Distances(mask);
    const int64_t width = mask.width, size = width * mask.height;
    for (int64_t t = 0; t < size; ++t) {
      double least = INFINITY;
      for (int64_t s = 0; s < size; ++s) {
        if (mask.blocked[s] == 0) {
          least = std::min(least, Way(s % width - t % width, s / width - t / width));
        }
      }
      if (std::isinf(least)) {
        ASSERT_EQ(distances[t], INFINITY);
      } else {
        ASSERT_NEAR(distances[t], least, kRounding * least) << "trial " << trial << ", texel " << t;
      }
    }
  }
}

TEST_P(DistanceSweepTest, IsNeverTooShortAndNotMuchTooLong) {
  const double most =
      GetParam() == SweepNeighbours::kFour ? std::sqrt(2.0) : 1 / std::cos(std::atan(1.0) / 2);
  Dice dice(2);
  tbb::task_arena arena(2);
  double longest = 1;
  for (int trial = 0; trial < 40; ++trial) {
    const OwnedMask mask = RandomMask(dice, 100 + dice.Below(200), 100 + dice.Below(200));
    const std::vector<float> exact = DistanceToLit(mask.View(), arena, {}).value();
    const std::vector<float> distances = Distances(mask);
    for (size_t t = 0; t < exact.size(); ++t) {
      ASSERT_GE(distances[t], exact[t] * (1 - kRounding)) << "trial " << trial << ", texel " << t;
      ASSERT_LE(distances[t], exact[t] * (most + kRounding)) << "trial " << trial;
      if (exact[t] > 0 && exact[t] < INFINITY) {
        longest = std::max(longest, double{distances[t]} / exact[t]);
      }
    }
  }
  EXPECT_GT(longest, 1 + 0.95 * (most - 1));
}

TEST_P(DistanceSweepTest, BesideAnUprightEdgeItIsExact) {
  OwnedMask mask(300, 40, true);
  for (int64_t y = 0; y < 40; ++y) {
    for (int64_t x = 200; x < 300; ++x) mask.At(x, y) = 0;
  }
  const std::vector<float> distances = Distances(mask);
  for (int64_t t = 0; t < 300 * 40; ++t) {
    ASSERT_EQ(distances[t], static_cast<float>(std::max<int64_t>(0, 200 - t % 300)));
  }
}

TEST_P(DistanceSweepTest, TheLongestWayFits) {
  constexpr int64_t kSide = kMaxMaskSide;
  OwnedMask mask(kSide, 2, true);
  mask.At(0, 0) = 0;
  EXPECT_NEAR(Distances(mask).back(), Way(kSide - 1, 1), 1e-3);
  const OwnedMask dark(3, kSide, true);
  EXPECT_THAT(Distances(dark), Each(INFINITY));
}

TEST_P(DistanceSweepTest, IsTheSameForAnyNumberOfThreads) {
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, 5);
  Dice dice(3);
  for (int trial = 0; trial < 6; ++trial) {
    const OwnedMask mask = RandomMask(dice, 300, 200);
    const std::vector<float> expected = Distances(mask, 1);
    EXPECT_EQ(Distances(mask, 2), expected);
    EXPECT_EQ(Distances(mask, 5), expected);
  }
}

TEST_P(DistanceSweepTest, AStopIsHeardAndWhatIsNoMaskRefused) {
  const OwnedMask mask(64, 64, true);
  tbb::task_arena arena(2);
  std::stop_source source;
  source.request_stop();
  EXPECT_EQ(DistanceBySweeps(mask.View(), GetParam(), arena, source.get_token()).status().code(),
            absl::StatusCode::kCancelled);
  const absl::Status refused =
      DistanceBySweeps({mask.blocked, 64, 63}, GetParam(), arena, {}).status();
  EXPECT_EQ(refused.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(refused.message()), ::testing::HasSubstr("found 4096 texels, need 4032"));
}

INSTANTIATE_TEST_SUITE_P(Neighbours, DistanceSweepTest,
                         ::testing::Values(SweepNeighbours::kFour, SweepNeighbours::kEight),
                         [](const auto& neighbours) {
                           return neighbours.param == SweepNeighbours::kFour ? "Four" : "Eight";
                         });

}  // namespace
}  // namespace penumbra
