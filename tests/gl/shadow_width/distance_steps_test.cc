// Distances in doubling steps by GL: against the same on the CPU, and on which side of the exact
// distance they err.
#include "render/technique/shadow_width/gl/distance_steps.h"

#include <gmock/gmock.h>

#include <cmath>

#include "render/technique/shadow_width/distance_exact.h"
#include "render/technique/shadow_width/distance_steps_cpu.h"
#include "tests/gl/display/software_context.h"
#include "tests/support/test_device.h"
#include "tests/unit/shadow_width/distance_masks.h"

namespace penumbra::testing {
namespace {

using ::testing::Each;
using ::testing::HasSubstr;

constexpr double kRounding = 1e-6;

class DistanceStepsTest : public SoftwareContextTest,
                          public ::testing::WithParamInterface<StepNeighbours> {
 protected:
  std::vector<float> Distances(const OwnedMask& mask) {
    auto distances = DistanceBySteps(*context_, mask.View(), GetParam(), {});
    EXPECT_TRUE(distances.ok()) << distances.status();
    return *std::move(distances);
  }
};

std::vector<float> DistancesOnCpu(const OwnedMask& mask, StepNeighbours neighbours) {
  std::vector<float> distances(mask.blocked.size());
  std::ranges::transform(mask.blocked, distances.begin(),
                         [](uint8_t blocked) { return blocked ? INFINITY : 0.0f; });
  const auto width = static_cast<int>(mask.width), height = static_cast<int>(mask.height);
  for (int size = 1; size < std::max(width, height); size *= 2) {
    const std::vector<float> before = distances;
    for (const DistanceStep& step : StepsOf(neighbours, size)) {
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          const int there_x = std::clamp(x + step.offset.x, 0, width - 1);
          const int there_y = std::clamp(y + step.offset.y, 0, height - 1);
          float& least = distances[y * width + x];
          least = std::min(least, before[there_y * width + there_x] + step.length);
        }
      }
    }
  }
  return distances;
}

// Of the test's own, and of the technique's.
TEST_P(DistanceStepsTest, AreThoseOfTheCpu) {
  Dice dice(1);
  tbb::task_arena arena(2);
  for (int trial = 0; trial < 60; ++trial) {
    const uint32_t most = trial % 10 == 0 ? 300 : 70;
    const OwnedMask mask = RandomMask(dice, 1 + dice.Below(most), 1 + dice.Below(most));
    const std::vector<float> expected = DistancesOnCpu(mask, GetParam());
    EXPECT_EQ(Distances(mask), expected)
        << "trial " << trial << ", " << mask.width << " x " << mask.height;
    EXPECT_EQ(DistanceByStepsOnCpu(mask.View(), GetParam(), arena, {}).value(), expected)
        << "trial " << trial << ", " << mask.width << " x " << mask.height;
  }
}

TEST_P(DistanceStepsTest, AreNeverTooShort) {
  Dice dice(2);
  tbb::task_arena arena(2);
  for (int trial = 0; trial < 20; ++trial) {
    const OwnedMask mask = RandomMask(dice, 50 + dice.Below(200), 50 + dice.Below(200));
    const std::vector<float> exact = DistanceToLit(mask.View(), arena, {}).value();
    const std::vector<float> distances = Distances(mask);
    for (size_t t = 0; t < exact.size(); ++t) {
      ASSERT_GE(distances[t], exact[t] * (1 - kRounding)) << "trial " << trial << ", texel " << t;
    }
  }
}

// Steps straight up are 1, 2, 4, … texels: any whole number is a sum of those.
TEST_P(DistanceStepsTest, BelowALevelEdgeAreExact) {
  OwnedMask mask(64, 200, true);
  for (int64_t y = 150; y < 200; ++y) {
    for (int64_t x = 0; x < 64; ++x) mask.At(x, y) = 0;
  }
  const std::vector<float> distances = Distances(mask);
  for (int64_t t = 0; t < 64 * 200; ++t) {
    ASSERT_EQ(distances[t], static_cast<float>(std::max<int64_t>(0, 150 - t / 64)));
  }
}

// The other way two steps of three must be taken for each one straight down.
TEST_P(DistanceStepsTest, AboveALevelEdgeThreeNeighboursGoALongWayRound) {
  OwnedMask mask(400, 100, true);
  for (int64_t x = 0; x < 400; ++x) mask.At(x, 0) = mask.At(x, 1) = mask.At(x, 2) = 0;
  const std::vector<float> distances = Distances(mask);
  for (int64_t y = 20; y < 100; ++y) {
    const auto exact = static_cast<double>(y - 2);
    const double ratio = distances[y * 400 + 200] / exact;
    if (GetParam() == StepNeighbours::kSix) {
      ASSERT_EQ(ratio, 1) << y;
    } else {
      ASSERT_NEAR(ratio, 2, 0.35) << y;
    }
  }
}

TEST_P(DistanceStepsTest, InADiskAreLongerByNoMoreThanTheirDirectionsAllow) {
  OwnedMask mask(256, 256, false);
  FillDisk(mask, 128, 128, 100, 1);
  tbb::task_arena arena(2);
  const std::vector<float> exact = DistanceToLit(mask.View(), arena, {}).value();
  const std::vector<float> distances = Distances(mask);
  double sum = 0, blocked = 0;
  for (size_t t = 0; t < exact.size(); ++t) {
    if (exact[t] == 0) continue;
    sum += distances[t] / exact[t] - 1;
    ++blocked;
  }
  // From a straight edge, and were any number of steps allowed, they would be 1 / cos of the angle
  // to the nearest direction too long: 1.05 on average of six, 1.26 of three. A round edge is
  // nearer; that each size of step is taken once makes ways longer.
  EXPECT_LT(sum / blocked, GetParam() == StepNeighbours::kSix ? 0.12 : 0.35);
  EXPECT_GT(sum / blocked, GetParam() == StepNeighbours::kSix ? 0.03 : 0.13);
}

TEST_P(DistanceStepsTest, OfOneTexelAndOfNoneLit) {
  EXPECT_THAT(Distances(OwnedMask(1, 1, false)), Each(0.0f));
  EXPECT_THAT(Distances(OwnedMask(1, 1, true)), Each(INFINITY));
  EXPECT_THAT(Distances(OwnedMask(37, 19, true)), Each(INFINITY));
  EXPECT_THAT(Distances(OwnedMask(37, 19, false)), Each(0.0f));
}

TEST_P(DistanceStepsTest, AStopIsHeardAndWhatIsNoMaskRefused) {
  const OwnedMask mask(20, 20, true);
  std::stop_source source;
  source.request_stop();
  EXPECT_EQ(DistanceBySteps(*context_, mask.View(), GetParam(), source.get_token()).status().code(),
            absl::StatusCode::kCancelled);
  tbb::task_arena arena(2);
  EXPECT_EQ(
      DistanceByStepsOnCpu(mask.View(), GetParam(), arena, source.get_token()).status().code(),
      absl::StatusCode::kCancelled);
  const absl::Status refused =
      DistanceBySteps(*context_, {mask.blocked, 20, 21}, GetParam(), {}).status();
  EXPECT_EQ(refused.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(refused.message()), HasSubstr("found 400 texels, need 420"));
}

TEST_P(DistanceStepsTest, ALostContextIsTold) {
  const OwnedMask mask(20, 20, true);
  auto lost = gl::Context::Create({.device = TestDevice()}).value();
  lost->SimulateLoss();
  EXPECT_EQ(DistanceBySteps(*lost, mask.View(), GetParam(), {}).status().code(),
            absl::StatusCode::kUnavailable);
}

INSTANTIATE_TEST_SUITE_P(Neighbours, DistanceStepsTest,
                         ::testing::Values(StepNeighbours::kThree, StepNeighbours::kSix),
                         [](const auto& neighbours) {
                           return neighbours.param == StepNeighbours::kThree ? "Three" : "Six";
                         });

TEST(DistanceStepsOffsetTest, LieAllRound) {
  for (int size = 1; size <= 4096; size *= 2) {
    for (const auto neighbours : {StepNeighbours::kThree, StepNeighbours::kSix}) {
      const std::vector<DistanceStep> steps = StepsOf(neighbours, size);
      EXPECT_EQ(steps.size(), neighbours == StepNeighbours::kThree ? 3u : 6u);
      EXPECT_EQ(steps[0].offset, glm::ivec2(0, size));
      for (const DistanceStep& step : steps) {
        EXPECT_NEAR(step.length, size, 0.45) << size;  // half a texel sideways, at 30°
        EXPECT_FLOAT_EQ(step.length, std::hypot(step.offset.x, step.offset.y));
      }
    }
  }
  EXPECT_EQ(StepsOf(StepNeighbours::kThree, 1)[1].offset, glm::ivec2(-1, 0));
  EXPECT_EQ(StepsOf(StepNeighbours::kThree, 8)[1].offset, glm::ivec2(-7, -4));
  EXPECT_EQ(StepsOf(StepNeighbours::kThree, 8)[2].offset, glm::ivec2(7, -4));
  EXPECT_EQ(StepsOf(StepNeighbours::kSix, 8)[3].offset, glm::ivec2(0, -8));
}

}  // namespace
}  // namespace penumbra::testing
