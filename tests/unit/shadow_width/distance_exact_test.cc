// The exact transform against trying all lit texels, and against closed forms.
#include "render/technique/shadow_width/distance_exact.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "hwy/targets.h"
#include "tbb/global_control.h"
#include "tests/unit/shadow_width/distance_masks.h"

namespace penumbra {
namespace {

using testing::Dice;
using ::testing::Each;
using ::testing::HasSubstr;
using testing::OwnedMask;
using testing::RandomMask;
using testing::SquaresByTrying;

std::vector<float> Distances(const OwnedMask& mask, int threads = 2) {
  tbb::task_arena arena(threads);
  return DistanceToLit(mask.View(), arena, {}).value();
}

void ExpectExact(const OwnedMask& mask) {
  const std::vector<float> distances = Distances(mask);
  const std::vector<int64_t> squares = SquaresByTrying(mask);
  ASSERT_EQ(distances.size(), squares.size());
  for (size_t t = 0; t < squares.size(); ++t) {
    const bool is_none = squares[t] == std::numeric_limits<int64_t>::max();
    const float expected = is_none ? INFINITY : std::sqrt(static_cast<float>(squares[t]));
    ASSERT_EQ(distances[t], expected) << "texel " << t % mask.width << ", " << t / mask.width
                                      << " of " << mask.width << " x " << mask.height;
  }
}

TEST(DistanceExactTest, IsThatOfTheNearestLitTexelInSmallMasks) {
  Dice dice(1);
  for (int trial = 0; trial < 4000; ++trial) {
    SCOPED_TRACE(trial);
    ExpectExact(RandomMask(dice, 1 + dice.Below(40), 1 + dice.Below(40)));
    if (HasFatalFailure()) return;
  }
}

// Wide shadows, many strips of rows, and widths that are no multiple of a vector's.
TEST(DistanceExactTest, IsThatOfTheNearestLitTexelInLargerMasks) {
  Dice dice(2);
  for (int trial = 0; trial < 60; ++trial) {
    SCOPED_TRACE(trial);
    OwnedMask mask = RandomMask(dice, 100 + dice.Below(200), 60 + dice.Below(200));
    if (trial % 3 == 0) {  // wide and narrow ones side by side
      mask = OwnedMask(300, 150, true);
      for (int k = 0; k < 40; ++k) mask.At(dice.Below(80), dice.Below(150)) = 0;
      mask.At(299, 149) = 0;
    }
    ExpectExact(mask);
    if (HasFatalFailure()) return;
  }
}

TEST(DistanceExactTest, IsThatOfTheNearestLitTexelInSingleRowsAndColumns) {
  Dice dice(3);
  for (uint32_t length = 1; length < 200; ++length) {
    SCOPED_TRACE(length);
    ExpectExact(RandomMask(dice, length, 1));
    ExpectExact(RandomMask(dice, 1, length));
    if (HasFatalFailure()) return;
  }
}

TEST(DistanceExactTest, AllLitAllBlockedAndCheckerboards) {
  for (const auto& [width, height] :
       {std::pair{1u, 1u}, std::pair{64u, 64u}, std::pair{33u, 97u}}) {
    EXPECT_THAT(Distances(OwnedMask(width, height, false)), Each(0.0f));
    EXPECT_THAT(Distances(OwnedMask(width, height, true)), Each(INFINITY));
    OwnedMask board(width, height, false);
    for (uint32_t y = 0; y < height; ++y) {
      for (uint32_t x = 0; x < width; ++x) board.At(x, y) = (x + y) % 2;
    }
    const std::vector<float> distances = Distances(board);
    for (size_t t = 0; t < distances.size(); ++t) ASSERT_EQ(distances[t], board.blocked[t]);
  }
}

TEST(DistanceExactTest, FromOneLitTexelItIsTheHypotenuse) {
  constexpr uint32_t kWidth = 203, kHeight = 171;
  for (const uint32_t cx : {0u, 77u, kWidth - 1}) {
    for (const uint32_t cy : {0u, 64u, kHeight - 1}) {
      OwnedMask mask(kWidth, kHeight, true);
      mask.At(cx, cy) = 0;
      const std::vector<float> distances = Distances(mask);
      for (uint32_t y = 0; y < kHeight; ++y) {
        for (uint32_t x = 0; x < kWidth; ++x) {
          ASSERT_FLOAT_EQ(distances[y * kWidth + x], std::hypot(1.0f * x - cx, 1.0f * y - cy))
              << x << ", " << y << " from " << cx << ", " << cy;
        }
      }
    }
  }
}

TEST(DistanceExactTest, BesideHalfAPlaneItIsTheWayStraightToIt) {
  OwnedMask left(500, 70, true), top(70, 500, true);
  for (uint32_t i = 0; i < 70; ++i) {
    for (uint32_t j = 300; j < 500; ++j) left.At(j, i) = top.At(i, j) = 0;
  }
  const std::vector<float> from_left = Distances(left), from_top = Distances(top);
  for (uint32_t i = 0; i < 70; ++i) {
    for (uint32_t j = 0; j < 500; ++j) {
      const float expected = j < 300 ? static_cast<float>(300 - j) : 0.0f;
      ASSERT_EQ(from_left[i * 500 + j], expected) << j;
      ASSERT_EQ(from_top[j * 70 + i], expected) << j;
    }
  }
}

// What lies outside is lit, and no point is further than √½ from a texel's centre.
TEST(DistanceExactTest, InADiskItIsWhatIsLeftOfTheRadius) {
  constexpr double kRadius = 90, kCentre = 128;
  OwnedMask mask(257, 257, false);
  testing::FillDisk(mask, kCentre, kCentre, kRadius, 1);
  const std::vector<float> distances = Distances(mask);
  for (int y = 0; y < 257; ++y) {
    for (int x = 0; x < 257; ++x) {
      const double left = kRadius - std::hypot(x - kCentre, y - kCentre);
      if (left < 0) continue;
      ASSERT_GT(distances[y * 257 + x], left) << x << ", " << y;
      ASSERT_LT(distances[y * 257 + x], left + std::sqrt(2.0)) << x << ", " << y;
    }
  }
}

TEST(DistanceExactTest, TheLongestDistancesFit) {
  constexpr uint32_t kSide = kMaxMaskSide;
  for (const bool is_tall : {false, true}) {
    OwnedMask mask(is_tall ? 3 : kSide, is_tall ? kSide : 3, true);
    mask.At(0, 0) = 0;
    const std::vector<float> distances = Distances(mask);
    const float most = kSide - 1;
    EXPECT_EQ(distances[is_tall ? 3 * (kSide - 1) : kSide - 1], most);
    EXPECT_FLOAT_EQ(distances.back(), std::hypot(most, 2.0f));
    EXPECT_EQ(distances[is_tall ? 3 * 4 + 2 : kSide + 5],
              std::sqrt(is_tall ? 16.0f + 4.0f : 25.0f + 1.0f));
  }
}

class DistanceTargetsTest : public ::testing::TestWithParam<int64_t> {
 protected:
  void SetUp() override { hwy::SetSupportedTargetsForTest(GetParam()); }
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }
};

TEST_P(DistanceTargetsTest, IsExact) {
  Dice dice(5);
  for (int trial = 0; trial < 300; ++trial) {
    const uint32_t most = trial % 10 == 0 ? 150 : 40;
    ExpectExact(RandomMask(dice, 1 + dice.Below(most), 1 + dice.Below(most)));
    if (HasFatalFailure()) return;
  }
}

INSTANTIATE_TEST_SUITE_P(Targets, DistanceTargetsTest,
                         ::testing::ValuesIn(hwy::SupportedAndGeneratedTargets()),
                         [](const auto& target) {
                           return std::string(hwy::TargetName(target.param));
                         });

TEST(DistanceExactTest, IsTheSameForAnyNumberOfThreads) {
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, 5);
  Dice dice(4);
  for (int trial = 0; trial < 12; ++trial) {
    const OwnedMask mask = RandomMask(dice, 300 + dice.Below(300), 300 + dice.Below(300));
    const std::vector<float> expected = Distances(mask, 1);
    EXPECT_EQ(Distances(mask, 2), expected);
    EXPECT_EQ(Distances(mask, 5), expected);
  }
}

TEST(DistanceExactTest, WritesOverAllOfTheMemoryThatIsReused) {
  tbb::task_arena arena(2);
  Dice dice(5);
  for (int trial = 0; trial < 20; ++trial) {
    const OwnedMask mask = RandomMask(dice, 1 + dice.Below(100), 1 + dice.Below(100));
    const std::vector<float> expected = Distances(mask, 2);
    for (const size_t size : {size_t{0}, expected.size() / 2, expected.size(), size_t{20'000}}) {
      std::vector<float> reused(size, -7.0f);
      EXPECT_EQ(DistanceToLit(mask.View(), arena, {}, std::move(reused)).value(), expected);
    }
  }
}

TEST(DistanceExactTest, AStopIsHeard) {
  const OwnedMask mask(64, 64, true);
  tbb::task_arena arena(2);
  std::stop_source source;
  source.request_stop();
  EXPECT_EQ(DistanceToLit(mask.View(), arena, source.get_token()).status().code(),
            absl::StatusCode::kCancelled);
}

TEST(DistanceExactTest, RefusesWhatIsNoMask) {
  const std::vector<uint8_t> blocked(12);
  tbb::task_arena arena(1);
  const auto refused = [&](uint32_t width, uint32_t height) {
    const absl::Status status = DistanceToLit({blocked, width, height}, arena, {}).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    return std::string(status.message());
  };
  EXPECT_THAT(refused(4, 4), HasSubstr("mask.blocked: found 12 texels, need 16"));
  EXPECT_THAT(refused(0, 12), HasSubstr("found 0 × 12 texels, need sides of 1 to 16384"));
  EXPECT_THAT(refused(12, 16385), HasSubstr("found 12 × 16385 texels"));
}

}  // namespace
}  // namespace penumbra
