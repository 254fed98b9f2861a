#include "render/technique/soft_texture/coverage_kernel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "hwy/targets.h"
#include "render/math/vec.h"
#include "render/technique/soft_texture/bit_counters.h"
#include "render/technique/soft_texture/edge_flags.h"

namespace penumbra {
namespace {

constexpr uint32_t kWidth = 150, kHeight = 90;  // no multiples of 32 or 16

struct Triangles {
  ProjectedVertices vertices;
  std::vector<uint32_t> corner0, corner1, corner2;
  std::vector<float> facing;

  void Add(Vec2 a, Vec2 b, Vec2 c, float face = 0) {
    points.insert(points.end(), {a, b, c});
    const auto first = static_cast<uint32_t>(points.size() - 3);
    corner0.push_back(first);
    corner1.push_back(first + 1);
    corner2.push_back(first + 2);
    facing.push_back(face);
  }
  TriangleList List() {
    vertices.Reserve(points.size());
    for (size_t i = 0; i < points.size(); ++i) {
      vertices.x[i] = points[i].x;
      vertices.y[i] = points[i].y;
      vertices.w[i] = 0.5f;
    }
    const auto count = static_cast<uint32_t>(corner0.size());
    for (auto* c : {&corner0, &corner1, &corner2}) c->resize(count + kMaxLanes);
    facing.resize(count + kMaxLanes);
    return {corner0.data(), corner1.data(), corner2.data(), facing.data(), count, 0};
  }
  std::vector<Vec2> points;
};

bool IsSet(const ShadowBitmap& bitmap, uint32_t column, uint32_t row) {
  return bitmap.Column(column / 32)[row] >> (column % 32) & 1;
}

// Each test runs on every instruction set that this machine has.
class CoverageKernelTest : public ::testing::TestWithParam<int64_t> {
 protected:
  void SetUp() override { hwy::SetSupportedTargetsForTest(GetParam()); }
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }

  ShadowBitmap Draw(Triangles& triangles) {
    ShadowBitmap bitmap(kWidth, kHeight);
    DrawTriangles(triangles.vertices, triangles.List(), {kWidth, 0, kHeight}, false, bitmap,
                  deferred_);
    return bitmap;
  }

  std::vector<uint32_t> deferred_;
  std::mt19937 random_{11};
};

TEST_P(CoverageKernelTest, SetsJustTheTexelsWhoseCentresAreInside) {
  std::uniform_real_distribution<float> x(-40, kWidth + 40.0f), y(-40, kHeight + 40.0f);
  for (int trial = 0; trial < 300; ++trial) {
    Triangles triangles;
    const Vec2 p[3] = {
        {x(random_), y(random_)}, {x(random_), y(random_)}, {x(random_), y(random_)}};
    triangles.Add(p[0], p[1], p[2]);
    const ShadowBitmap bitmap = Draw(triangles);
    for (uint32_t row = 0; row < kHeight; ++row) {
      for (uint32_t column = 0; column < kWidth; ++column) {
        // Signed distances to the three edges, in double precision.
        double nearest = 1e30;
        int positive = 0;
        for (int k = 0; k < 3; ++k) {
          const DVec2 a(p[k]), edge = DVec2(p[(k + 1) % 3]) - a, d = DVec2(column, row) - a;
          const double distance = (edge.x * d.y - edge.y * d.x) / glm::length(edge);
          positive += distance > 0;
          nearest = std::min(nearest, std::abs(distance));
        }
        if (nearest < 1e-3) continue;
        ASSERT_EQ(IsSet(bitmap, column, row), positive == 0 || positive == 3)
            << "texel " << column << ", " << row << " of trial " << trial;
      }
    }
  }
}

// A fan around one point, every edge shared by two triangles: each texel inside must be covered by
// exactly one.
TEST_P(CoverageKernelTest, LeavesNoGapAndNoOverlapBetweenNeighbours) {
  std::uniform_real_distribution<float> jitter(-0.4f, 0.4f);
  constexpr int kSide = 12;
  std::vector<Vec2> grid;
  for (int j = 0; j <= kSide; ++j) {
    for (int i = 0; i <= kSide; ++i) {
      const bool border = i == 0 || j == 0 || i == kSide || j == kSide;
      const Vec2 shift = border ? Vec2(0) : Vec2(jitter(random_), jitter(random_));
      grid.push_back((Vec2(i, j) + shift) * Vec2(kWidth / float{kSide}, kHeight / float{kSide}) -
                     Vec2(0.5f));
    }
  }
  std::vector<int> covered(kWidth * kHeight, 0);
  for (int j = 0; j < kSide; ++j) {
    for (int i = 0; i < kSide; ++i) {
      const int c = j * (kSide + 1) + i;
      for (const auto& t :
           {std::array{c, c + 1, c + kSide + 1}, std::array{c + 1, c + kSide + 2, c + kSide + 1}}) {
        Triangles triangles;
        triangles.Add(grid[t[0]], grid[t[1]], grid[t[2]]);
        const ShadowBitmap bitmap = Draw(triangles);
        for (uint32_t texel = 0; texel < kWidth * kHeight; ++texel) {
          covered[texel] += IsSet(bitmap, texel % kWidth, texel / kWidth);
        }
      }
    }
  }
  EXPECT_EQ(std::count(covered.begin(), covered.end(), 1), kWidth * kHeight);
}

TEST_P(CoverageKernelTest, LeavesOutFacesThatLookAway) {
  Triangles triangles;
  triangles.Add({10, 10}, {50, 10}, {10, 50}, 1);      // positive area: kept
  triangles.Add({60, 10}, {60, 50}, {100, 10}, 1);     // negative: left out
  triangles.Add({110, 10}, {110, 50}, {140, 10}, -1);  // negative, as wanted
  const ShadowBitmap bitmap = Draw(triangles);
  EXPECT_TRUE(IsSet(bitmap, 15, 15));
  EXPECT_FALSE(IsSet(bitmap, 65, 15));
  EXPECT_TRUE(IsSet(bitmap, 115, 15));
}

TEST_P(CoverageKernelTest, DefersWhatSinglePrecisionWouldBlur) {
  Triangles triangles;
  triangles.Add({10, 10}, {50, 10}, {10, 50});
  triangles.Add({-5000, 10}, {50, 10}, {10, 50});
  triangles.Add({-5000, 10}, {-4000, 10}, {-4500, 50});  // far outside: simply left out
  Draw(triangles);
  EXPECT_EQ(deferred_, std::vector<uint32_t>{1});
}

TEST_P(CoverageKernelTest, NeverDrawsNotANumber) {
  Triangles triangles;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  triangles.Add({nan, 10}, {50, 10}, {10, 50});
  triangles.Add({10, nan}, {50, 10}, {10, 50});
  triangles.Add({inf, -inf}, {50, 10}, {10, 50});
  triangles.Add({20, 20}, {20, 20}, {20, 20});
  triangles.Add({20, 20}, {40, 20}, {60, 20});
  const ShadowBitmap bitmap = Draw(triangles);
  EXPECT_EQ(std::count(bitmap.words.begin(), bitmap.words.end(), 0u),
            static_cast<std::ptrdiff_t>(bitmap.words.size()));
}

// Sets about two thirds of the bits, and counts them in `expected`.
void Scatter(std::mt19937& random, ShadowBitmap& bitmap, std::vector<uint16_t>& expected) {
  for (uint32_t texel = 0; texel < kWidth * kHeight; ++texel) {
    if (random() % 3 == 0) continue;
    const uint32_t column = texel % kWidth, row = texel / kWidth;
    bitmap.Column(column / 32)[row] |= 1u << (column % 32);
    bitmap.Touch(column / 32, column / 32 + 1, row, row + 1);
    ++expected[texel];
  }
}

TEST_P(CoverageKernelTest, CountsEveryBitmapThatWasAdded) {
  BitmapCounter counter(kWidth, kHeight, 700);
  for (const int samples : {1, 2, 3, 4, 5, 31, 255, 256, 700}) {
    std::vector<uint16_t> expected(kWidth * kHeight, 0), found(kWidth * kHeight, 1000);
    for (int sample = 0; sample < samples; ++sample) {
      Scatter(random_, counter.next(), expected);
      counter.CountNext();
    }
    counter.Finish();
    counter.SubtractFrom(found.data(), kWidth, 0, kHeight);
    for (uint16_t& count : found) count = static_cast<uint16_t>(1000 - count);
    ASSERT_EQ(found, expected) << samples;
    Scatter(random_, counter.next(), expected);  // and does not count it
    counter.Clear();
  }
}

TEST_P(CoverageKernelTest, MergesWhatThreadsHaveCounted) {
  std::vector<BitmapCounter> counters(3, BitmapCounter(kWidth, kHeight, 60));
  std::vector<uint16_t> expected(kWidth * kHeight, 0), found(kWidth * kHeight, 60);
  for (int sample = 0; sample < 60; ++sample) {
    BitmapCounter& counter = counters[sample % 7 % 3];
    Scatter(random_, counter.next(), expected);
    counter.CountNext();
  }
  for (BitmapCounter& counter : counters) counter.Finish();
  counters[0].Touch(0, kHeight);
  for (uint32_t begin = 0; begin < kHeight; begin += 2 * BitmapCounter::kRowStep) {
    const uint32_t end = std::min(begin + 2 * BitmapCounter::kRowStep, kHeight);
    counters[0].Merge(counters[1], begin, end);
    counters[0].Merge(counters[2], begin, end);
    counters[0].SubtractFrom(found.data(), kWidth, begin, end);
  }
  for (uint16_t& count : found) count = static_cast<uint16_t>(60 - count);
  EXPECT_EQ(found, expected);
  // What came from others is forgotten with the rest.
  counters[0].Clear();
  counters[0].SubtractFrom(found.data(), kWidth, 0, kHeight);
  EXPECT_EQ(found, expected);
}

// Corners a hair's breadth off texel centres: there a crossing may round past its edge's own end.
TEST_P(CoverageKernelTest, FlagsFillWhatTrianglesCover) {
  std::mt19937 random(7);
  // Projected places are multiples of the last digit of the ½ that is taken off them, at least.
  const auto at = [&](uint32_t n) {
    float x = static_cast<float>(random() % n);
    for (uint32_t k = random() % 4; k > 0; --k) {
      const bool up = random() % 2;
      x = std::abs(x) < 0.5f ? x + (up ? 0x1p-25f : -0x1p-25f) : std::nextafter(x, up ? 1e9f : 0);
    }
    return x;
  };
  EdgeFlags flags(kWidth, kHeight);
  for (int trial = 0; trial < 20000; ++trial) {
    Triangles triangles;
    for (int t = 0; t < 3; ++t) {
      const Vec2 a(at(kWidth), at(kHeight)), b(at(kWidth), at(kHeight));
      triangles.Add(a, b, t == 0 ? Vec2(a.x, b.y) : Vec2(at(kWidth), at(kHeight)));
    }
    const ShadowBitmap filled = Draw(triangles);
    ShadowBitmap flagged(kWidth, kHeight);
    FlagTriangles(triangles.vertices, triangles.List(), {kWidth, 0, kHeight}, false, flags,
                  deferred_);
    FillFromFlags({kWidth, 0, kHeight}, flags, flagged);
    for (uint32_t row = 0; row < kHeight; ++row) {
      for (uint32_t column = 0; column < kWidth; ++column) {
        ASSERT_EQ(IsSet(filled, column, row), IsSet(flagged, column, row))
            << "trial " << trial << ", column " << column << ", row " << row;
      }
    }
    ASSERT_TRUE(std::all_of(flags.change.begin(), flags.change.end(), [](int32_t change) {
      return change == 0;
    })) << trial;
  }
}

// x = 89.0000076 in row 110 of an edge that ends at 89.
TEST_P(CoverageKernelTest, AFlagBeyondItsEdgeIsNotLost) {
  Triangles triangles;
  triangles.Add(Vec2(20.9999943f, 9.0000038f), Vec2(89, 110.0000076f), Vec2(21, 110.0000076f));
  EdgeFlags flags(200, 120);
  ShadowBitmap bitmap(200, 120);
  FlagTriangles(triangles.vertices, triangles.List(), {200, 0, 120}, false, flags, deferred_);
  FillFromFlags({200, 0, 120}, flags, bitmap);
  for (uint32_t column = 92; column < 200; ++column) EXPECT_FALSE(IsSet(bitmap, column, 110));
  EXPECT_TRUE(std::all_of(flags.change.begin(), flags.change.end(),
                          [](int32_t change) { return change == 0; }));
}

INSTANTIATE_TEST_SUITE_P(EveryTarget, CoverageKernelTest,
                         ::testing::ValuesIn(hwy::SupportedAndGeneratedTargets()),
                         [](const auto& target) {
                           return std::string(hwy::TargetName(target.param));
                         });

}  // namespace
}  // namespace penumbra
