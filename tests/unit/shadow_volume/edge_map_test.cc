#include "render/technique/shadow_volume/edge_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "render/technique/shadow_volume/edge_kernel.h"
#include "tests/unit/shadow_volume/depth_maps.h"

namespace penumbra {
namespace {

using testing::Dice;
using testing::MapOf;
using testing::RandomMap;
using testing::SomeView;
using testing::SquareOverSlope;

VolumeGrid GridOf(const DepthMap& map) { return VolumeGrid(map, VolumeBorder::kNothing, 0); }

// Every difference against its limit, one by one and in double precision.
TEST(EdgeMapTest, PlainThresholdsMarkWhatIsAboveThem) {
  Dice dice(7);
  for (const bool from_infinity : {false, true}) {
    for (const uint32_t width : {1u, 5u, 63u, 64u, 65u, 130u}) {
      const VolumeGrid grid = GridOf(RandomMap(dice, SomeView(width, 9, from_infinity)));
      const EdgeThresholds plain{.low = 30, .high = 30};
      const EdgeMap edges = FindEdges(grid, {.thresholds = plain, .follows_dangling = false});
      const auto is_edge = [&](uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1) {
        const double a = grid.At(x0, y0), b = grid.At(x1, y1);
        if (a == b) return false;
        if (std::min(a, b) == grid.nothing()) return true;
        return std::abs(a - b) > 30.0 * grid.PixelWidth(static_cast<float>(std::max(a, b)));
      };
      for (uint32_t y = 0; y < grid.height(); ++y) {
        for (uint32_t x = 0; x < grid.width(); ++x) {
          if (x + 1 < grid.width()) {
            EXPECT_EQ(edges.right(x, y), is_edge(x, y, x + 1, y)) << x << " " << y;
          }
          if (y + 1 < grid.height()) {
            EXPECT_EQ(edges.below(x, y), is_edge(x, y, x, y + 1)) << x << " " << y;
          }
        }
      }
    }
  }
}

// All around a square of 8 samples that has nothing behind it, or something far off.
TEST(EdgeMapTest, OutlinesAgainstNothingAreEdgesFromAnywhere) {
  for (const bool from_infinity : {false, true}) {
    for (const float behind : {kNoDepth, 50.0f}) {
      const VolumeGrid grid =
          GridOf(MapOf(SomeView(20, 20, from_infinity), [&](uint32_t x, uint32_t y) {
            return x >= 6 && x < 14 && y >= 6 && y < 14 ? 3.0f : behind;
          }));
      const size_t around_it = 4 * 8, around_all = behind == kNoDepth ? 0 : 4 * 20;
      EXPECT_EQ(FindEdges(grid, {}).flag_count(), around_it + around_all)
          << from_infinity << " " << behind;
    }
  }
}

TEST(EdgeMapTest, CellsAreVisitedOnceEachInTheirOrder) {
  Dice dice(8);
  const VolumeGrid grid = GridOf(RandomMap(dice, SomeView(140, 20, false), 0.05f));
  const EdgeMap edges = FindEdges(grid, {.thresholds = EdgeThresholds{.low = 90, .high = 90}});
  std::vector<int> codes(size_t{grid.width()} * grid.height());
  size_t last = 0;
  edges.ForEachCell([&](uint32_t x, uint32_t y, int code) {
    const size_t at = size_t{y} * grid.width() + x;
    EXPECT_TRUE(at > last || at == 0);
    last = at;
    codes[at] = code;
  });
  for (uint32_t y = 0; y + 1 < grid.height(); ++y) {
    for (uint32_t x = 0; x + 1 < grid.width(); ++x) {
      const int code = edges.right(x, y) + 2 * edges.below(x + 1, y) + 4 * edges.right(x, y + 1) +
                       8 * edges.below(x, y);
      EXPECT_EQ(codes[size_t{y} * grid.width() + x], code);
    }
  }
}

// A slope of 1 to 3 pixels' widths a pixel is above the low threshold, and none of it is an edge;
// the square's sides are, all around.
TEST(EdgeMapTest, SlopesAreNoEdgesAndStepsAre) {
  const EdgeOptions options{.thresholds = EdgeThresholds{.low = 0.5f, .high = 20}};
  const VolumeGrid slope = GridOf(SquareOverSlope(64, 1.5, 0));
  const VolumeGrid square = GridOf(SquareOverSlope(64, 1.5, 6));
  const EdgeMap none = FindEdges(slope, options), some = FindEdges(square, options);
  for (uint32_t y = 2; y < 63; ++y) {
    for (uint32_t x = 2; x < 63; ++x) {
      EXPECT_FALSE(none.right(x, y)) << x << " " << y;
      EXPECT_FALSE(none.below(x, y)) << x << " " << y;
      const bool in_rows = y > 16 && y <= 48, in_columns = x > 16 && x <= 48;
      EXPECT_EQ(some.right(x, y), in_rows && (x == 16 || x == 48)) << x << " " << y;
      EXPECT_EQ(some.below(x, y), in_columns && (y == 16 || y == 48)) << x << " " << y;
    }
  }
}

// A step that a sample lies in the middle of has two halves, of which neither is greater.
// A table seen from just above it: in nearness a slope down to its vanishing line, and what is
// behind it is not much further than that.
TEST(EdgeMapTest, SlopesEndAtTheirVanishingLine) {
  for (const double missing : {0.01, 0.05, 0.3, 0.7, 0.99}) {
    for (const bool is_upside_down : {false, true}) {
      const VolumeGrid grid = GridOf(MapOf(SomeView(30, 30, false), [&](uint32_t, uint32_t y) {
        const uint32_t row = is_upside_down ? 29 - y : y;
        return row <= 20 ? static_cast<float>(1 / (21 - missing - row)) : 50.0f;
      }));
      const EdgeMap edges = FindEdges(grid, {});
      // The grid has a border of one. The last step of the slope may be taken for its end.
      const uint32_t end = is_upside_down ? 9 : 21, last = is_upside_down ? 10 : 20;
      for (uint32_t y = 1; y + 2 < grid.height(); ++y) {
        if (y == last) continue;
        EXPECT_EQ(edges.below(15, y), y == end) << missing << " " << is_upside_down << " " << y;
      }
    }
  }
}

TEST(EdgeMapTest, StepsOfTwoHalvesAreEdges) {
  const double pixel = 0.7 / 40;
  const VolumeGrid grid = GridOf(MapOf(SomeView(40, 40, false), [&](uint32_t x, uint32_t) {
    return static_cast<float>(4 / (1 + pixel * (x < 20 ? 0 : x == 20 ? 3 : 6)));
  }));
  const EdgeMap edges = FindEdges(grid, {.thresholds = EdgeThresholds{.low = 2, .high = 20}});
  EXPECT_TRUE(edges.right(20, 20));
  EXPECT_TRUE(edges.right(21, 20));
  EXPECT_FALSE(edges.right(19, 20));
  EXPECT_FALSE(edges.right(22, 20));
}

// A flap that leaves the floor more and more, row by row: where the step is below the threshold the
// edge ends, unless it is followed.
TEST(EdgeMapTest, DanglingEdgesAreFollowed) {
  const double pixel = 0.7 / 40;
  const VolumeGrid grid = GridOf(MapOf(SomeView(40, 40, false), [&](uint32_t x, uint32_t y) {
    return static_cast<float>(4 / (1 + pixel * (x < 20 ? 0.0 : 0.2 * y)));
  }));
  const EdgeThresholds thresholds{.low = 4, .high = 4, .second = 0.5f, .dangling = 0.5f};
  const EdgeMap cut = FindEdges(grid, {.thresholds = thresholds, .follows_dangling = false});
  const EdgeMap followed = FindEdges(grid, {.thresholds = thresholds});
  for (uint32_t y = 0; y < 40; ++y) {
    const double step = 0.2 * y / (1 + pixel * 0.2 * y) * 1.0;
    if (std::abs(step - 4) > 0.4) {
      EXPECT_EQ(cut.right(20, y + 1), step > 4) << y;
    }
    if (std::abs(step - 2) > 0.4) {
      EXPECT_EQ(followed.right(20, y + 1), step > 2) << y;
    }
  }
}

TEST(EdgeMapTest, OtherObjectsAreEdges) {
  const DepthMap map = MapOf(SomeView(10, 8, false), [](uint32_t, uint32_t) { return 4.0f; });
  std::vector<uint32_t> ids(80);
  for (uint32_t i = 0; i < 80; ++i) ids[i] = i % 10 >= 4 && i / 10 >= 3;
  const EdgeMap edges = FindEdges(GridOf(map), {}, ids);
  for (uint32_t y = 1; y <= 8; ++y) {
    for (uint32_t x = 1; x <= 9; ++x) EXPECT_EQ(edges.right(x, y), x == 4 && y > 3);
  }
  for (uint32_t x = 1; x <= 10; ++x) {
    for (uint32_t y = 1; y <= 7; ++y) EXPECT_EQ(edges.below(x, y), y == 3 && x > 4);
  }
}

TEST(EdgeMapTest, FractionIsOfPlacesThatSeeSomething) {
  const VolumeGrid none =
      GridOf(MapOf(SomeView(8, 8, false), [](uint32_t, uint32_t) { return kNoDepth; }));
  EXPECT_EQ(FindEdges(none, {}).fraction(), 0.0);
  Dice dice(9);
  const VolumeGrid grid = GridOf(RandomMap(dice, SomeView(8, 8, false), 0));
  // All but those between samples of the ring.
  const EdgeMap all = FindEdges(grid, {.thresholds = EdgeThresholds{.low = 0, .high = 0}});
  EXPECT_EQ(all.flag_count(), 2u * 9 * 8);
  EXPECT_EQ(all.fraction(), 1.0);
  EXPECT_EQ(FindEdges(VolumeGrid(DepthMap{}, VolumeBorder::kNothing, 0), {}).fraction(), 0.0);
}

TEST(EdgeThresholdsTest, BinsAreInOrderAndHoldTheirLeast) {
  for (int bin = 0; bin < kDifferenceBins; ++bin) {
    EXPECT_EQ(DifferenceBin(DifferenceOfBin(bin)), bin);
    if (bin > 0) {
      EXPECT_LT(DifferenceOfBin(bin - 1), DifferenceOfBin(bin));
    }
  }
  EXPECT_EQ(DifferenceBin(NAN), 0);
  EXPECT_EQ(DifferenceBin(0), 0);
  EXPECT_EQ(DifferenceBin(INFINITY), kDifferenceBins - 1);
  EXPECT_EQ(DifferenceBin(1.0f), DifferenceBin(1.24f));
  EXPECT_LT(DifferenceBin(1.24f), DifferenceBin(1.26f));
}

TEST(EdgeThresholdsTest, NoisyMapsGetHigherThresholds) {
  Dice dice(10);
  const auto with_noise = [&](float size) {
    const VolumeGrid grid = GridOf(MapOf(SomeView(510, 254, false), [&](uint32_t, uint32_t) {
      return 4 + dice.Between(-size, size);
    }));
    const EdgeThresholds thresholds = ChooseThresholds(grid);
    EXPECT_EQ(thresholds.high, 4 * thresholds.low);
    return thresholds.low;
  };
  EXPECT_EQ(with_noise(0.0001f), 2.0f);
  EXPECT_EQ(with_noise(2.0f), 2.5f);
}

}  // namespace
}  // namespace penumbra
