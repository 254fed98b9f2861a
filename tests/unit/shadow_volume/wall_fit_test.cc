#include "render/technique/shadow_volume/wall_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <tuple>
#include <utility>

#include "render/technique/shadow_volume/shadow_volume_builder.h"
#include "render/technique/shadow_volume/wall_edges.h"
#include "tests/unit/shadow_volume/crossings.h"
#include "tests/unit/shadow_volume/depth_maps.h"

namespace penumbra {
namespace {

using testing::CrossingsOf;
using testing::Dice;
using testing::MapOf;
using testing::RandomMap;
using testing::SomeView;

constexpr EdgeThresholds kPlain{.low = 20, .high = 20};

DVec2 PlaceOf(GridCorner corner) { return DVec2(corner.x, corner.y); }

VolumeGrid GridOf(const DepthMap& map) { return VolumeGrid(map, VolumeBorder::kNothing, 0); }

TEST(ContourTraceTest, EachEdgeIsAGateOnce) {
  Dice dice(31);
  for (const VolumeBorder border : {VolumeBorder::kNothing, VolumeBorder::kOthers}) {
    for (int trial = 0; trial < 20; ++trial) {
      const DepthMap map = RandomMap(dice, SomeView(24, 21, false), 0.1f);
      const VolumeGrid grid(map, border, 0);
      const EdgeMap edges = FindEdges(grid, {.thresholds = EdgeThresholds{.low = 60, .high = 60}});
      std::set<std::tuple<uint32_t, uint32_t, bool>> gates;
      for (const Contour& contour : TraceContours(grid, edges)) {
        for (const ContourGate& gate : contour.gates) {
          const DVec2 step = glm::abs(PlaceOf(gate.left) - PlaceOf(gate.right));
          EXPECT_EQ(step.x + step.y, 1);
          const uint32_t x = std::min(gate.left.x, gate.right.x);
          const uint32_t y = std::min(gate.left.y, gate.right.y);
          EXPECT_TRUE(gates.insert({x, y, step.x == 1}).second);
          EXPECT_TRUE(step.x == 1 ? edges.right(x, y) : edges.below(x, y));
        }
      }
      size_t expected = 0;
      const uint32_t first = grid.first_cell();
      for (uint32_t y = first; y <= grid.end_cell_y(); ++y) {
        for (uint32_t x = first; x <= grid.end_cell_x(); ++x) {
          expected += x < grid.end_cell_x() && edges.right(x, y);
          expected += y < grid.end_cell_y() && edges.below(x, y);
        }
      }
      EXPECT_EQ(gates.size(), expected);
    }
  }
}

// Left stays left: from gate to gate one of a contour's samples stays, or both go on side by side.
TEST(ContourTraceTest, SidesAreKept) {
  Dice dice(32);
  const VolumeGrid grid = GridOf(RandomMap(dice, SomeView(30, 30, false), 0.1f));
  const EdgeMap edges = FindEdges(grid, {.thresholds = EdgeThresholds{.low = 60, .high = 60}});
  for (const Contour& contour : TraceContours(grid, edges)) {
    for (size_t i = 1; i < contour.gates.size(); ++i) {
      const DVec2 a =
          0.5 * (PlaceOf(contour.gates[i - 1].left) + PlaceOf(contour.gates[i - 1].right));
      const DVec2 b = 0.5 * (PlaceOf(contour.gates[i].left) + PlaceOf(contour.gates[i].right));
      const DVec2 way = b - a, left = PlaceOf(contour.gates[i].left) - b;
      EXPECT_LE(glm::length(way), 1.001);
      EXPECT_GT(way.x * left.y - way.y * left.x, 0);
      EXPECT_LE(glm::distance(PlaceOf(contour.gates[i].left), PlaceOf(contour.gates[i - 1].left)),
                1.5);
    }
  }
}

// A surface one sample wide that runs aslant is one, over a floor and over nothing.
TEST(ContourTraceTest, SamplesAcrossACellHangTogether) {
  constexpr float kNothing = std::numeric_limits<float>::infinity();
  for (const auto& [on, off] : {std::pair(3.0f, 6.0f), {3.0f, kNothing}}) {
    for (const bool rises : {false, true}) {
      const VolumeGrid grid = GridOf(MapOf(SomeView(40, 40, false), [&](uint32_t x, uint32_t y) {
        const bool is_on = x == (rises ? y : 39 - y) && x >= 10 && x < 30;
        return is_on ? on + 0.001f * static_cast<float>(x) : off;
      }));
      const EdgeMap edges = FindEdges(grid, {.thresholds = kPlain});
      size_t around = 0;
      for (const Contour& contour : TraceContours(grid, edges)) {
        EXPECT_TRUE(contour.is_closed);
        around += contour.gates.size() == 4 * 20;
      }
      EXPECT_EQ(around, 1u) << on << " " << off << " " << rises;
    }
  }
}

// Of unlike samples none hang together.
TEST(ContourTraceTest, WaysEndWhereFourSurfacesMeet) {
  const VolumeGrid grid = GridOf(MapOf(SomeView(20, 20, false), [](uint32_t x, uint32_t y) {
    return 2.0f + static_cast<float>(x >= 10) + 2 * static_cast<float>(y >= 10);
  }));
  size_t ends = 0;
  for (const Contour& contour :
       TraceContours(grid, FindEdges(grid, {.thresholds = EdgeThresholds{.low = 1, .high = 1}}))) {
    for (const auto& cell : {contour.first_cell, contour.last_cell}) {
      ends += cell && cell->x == 10 && cell->y == 10;
    }
  }
  EXPECT_EQ(ends, 4u);
}

// A round disk over a floor: walls go between the samples of either, and are few.
TEST(WallFitTest, LinesPassBetweenSamplesOfBothSurfaces) {
  const LightView view = SomeView(80, 80, false);
  const VolumeGrid grid = GridOf(MapOf(view, [](uint32_t x, uint32_t y) {
    return std::hypot(x - 39.3, y - 41.1) < 25.2 ? 3.0f : 6.0f;
  }));
  const EdgeMap edges = FindEdges(grid, {.thresholds = kPlain});
  size_t round = 0;
  for (const Contour& contour : TraceContours(grid, edges)) {
    const std::vector<WallPost> posts = FitWall(grid, edges, contour);
    if (!contour.is_closed || contour.gates.size() > 250) continue;  // not the map's border
    ++round;
    EXPECT_LT(posts.size(), contour.gates.size() / 5);
    EXPECT_EQ(posts.front().at, posts.back().at);
    size_t post = 0;
    for (const ContourGate& gate : contour.gates) {
      const DVec2 left = PlaceOf(gate.left), right = PlaceOf(gate.right);
      const auto side = [&](DVec2 p) {
        const DVec2 way = posts[post + 1].at - posts[post].at, off = p - posts[post].at;
        return way.x * off.y - way.y * off.x;
      };
      const auto is_between = [&] { return side(left) > -1e-9 && side(right) < 1e-9; };
      while (!is_between() && post + 2 < posts.size()) ++post;
      EXPECT_TRUE(is_between());
    }
    for (const WallPost& at : posts) {
      EXPECT_NEAR(glm::distance(at.at - 1.0, DVec2(39.3, 41.1)), 25.2, 0.9);
      EXPECT_NEAR(std::max(at.left.nearness, at.right.nearness), 1.0 / 3, 1e-6);
      EXPECT_NEAR(std::min(at.left.nearness, at.right.nearness), 1.0 / 6, 1e-6);
    }
  }
  EXPECT_EQ(round, 1u);
}

// The volume of that disk against the disk itself, by segments that end neither near the shadow's
// rim nor beyond the floor.
TEST(WallFitTest, WallsEncloseTheShadow) {
  Dice dice(33);
  for (const bool is_mirrored : {false, true}) {
    LightView view = SomeView(80, 80, false);
    if (is_mirrored) view.frame.axes.t = -view.frame.axes.t;
    const DepthMap map = MapOf(view, [](uint32_t x, uint32_t y) {
      return std::hypot(x - 39.3, y - 41.1) < 25.2 ? 3.0f : 6.0f;
    });
    ShadowVolumeOptions options{.vectorizes = true, .bias_px = 0};
    options.edges.thresholds = kPlain;
    const ShadowVolume volume = ReconstructVolume({{.map = map}}, options, {}).value().volume;
    EXPECT_EQ(volume.kind, VolumeKind::kVectorized);
    const VolumeTriangles mesh{volume.vertices, volume.indices};
    const auto end = [&](bool inside) {
      const double radius = inside ? dice.Between(0, 23.5f) : dice.Between(27, 36);
      const double angle = dice.Between(0, 6.28f);
      const DVec2 pixel(39.8 + radius * std::cos(angle), 41.6 + radius * std::sin(angle));
      return view.PointAt(pixel, dice.Between(3.2f, 5.8f));
    };
    for (int i = 0; i < 500; ++i) {
      const bool from_inside = dice.Below(2) == 0, to_inside = dice.Below(2) == 0;
      const auto crossings = CrossingsOf(mesh, end(from_inside), end(to_inside));
      if (!crossings) continue;
      EXPECT_EQ(crossings->in, int{to_inside} - int{from_inside}) << i;
    }
  }
}

// The disk over a floor with a step: where the step's wall meets the disk's nothing slips through.
TEST(WallFitTest, WallsThatMeetLeaveNoGap) {
  Dice dice(35);
  const LightView view = SomeView(80, 80, false);
  const auto radius = [](DVec2 pixel) { return glm::distance(pixel, DVec2(39.8, 41.6)); };
  const DepthMap map = MapOf(view, [&](uint32_t x, uint32_t y) {
    return radius(DVec2(x + 0.5, y + 0.5)) < 25.2 ? 3.0f : x < 40 ? 8.0f : 5.0f;
  });
  ShadowVolumeOptions options{.vectorizes = true, .bias_px = 0};
  options.edges.thresholds = kPlain;
  const ShadowVolume volume = ReconstructVolume({{.map = map}}, options, {}).value().volume;
  const VolumeTriangles mesh{volume.vertices, volume.indices};
  size_t crossed = 0;
  for (int i = 0; i < 4000; ++i) {
    const DVec2 meeting(40, dice.Below(2) == 0 ? 41.6 - 25.2 : 41.6 + 25.2);
    const DVec2 at = meeting + DVec2(dice.Between(-1, 1), dice.Between(-1, 1));
    const double angle = dice.Between(0, 6.28f), depth = dice.Between(3.3f, 4.7f);
    const DVec2 from = at + 4.0 * DVec2(std::cos(angle), std::sin(angle)), to = 2.0 * at - from;
    const auto is_unsure = [&](DVec2 pixel) { return std::abs(radius(pixel) - 25.2) < 1.8; };
    if (is_unsure(from) || is_unsure(to)) continue;
    const double lean = dice.Between(-0.1f, 0.1f);
    const auto crossings =
        CrossingsOf(mesh, view.PointAt(from, depth - lean), view.PointAt(to, depth + lean));
    if (!crossings) continue;
    ++crossed;
    EXPECT_EQ(crossings->in, int{radius(to) < 25.2} - int{radius(from) < 25.2}) << i;
  }
  EXPECT_GT(crossed, 1000u);
}

// Steep disks, down to such as are a sample wide: walls begin on their planes, though at their edge
// nothing may tell of their slope.
TEST(WallFitTest, WallsBeginOnPlanesHoweverSteep) {
  Dice dice(34);
  size_t begins = 0;
  for (int trial = 0; trial < 50; ++trial) {
    const DVec2 way = glm::normalize(DVec2(dice.Between(-1, 1), dice.Between(-1, 1)));
    const double width = dice.Between(0.6f, 6), slope = 0.02;  // about 7 pixels' widths
    const auto plane = [&](DVec2 at) { return 0.3 + slope * glm::dot(at - DVec2(40.2), way); };
    const VolumeGrid grid = GridOf(MapOf(SomeView(80, 80, false), [&](uint32_t x, uint32_t y) {
      const DVec2 at(x + 1, y + 1), off = at - DVec2(40.2);  // in the grid, which has a ring
      const double along = (way.x * off.y - way.y * off.x) / 25;
      const double across = glm::dot(off, way) / width;
      return across * across + along * along < 1 ? static_cast<float>(1 / plane(at)) : 8.0f;
    }));
    const EdgeMap edges = FindEdges(grid, {.thresholds = kPlain});
    for (const Contour& contour : TraceContours(grid, edges)) {
      const std::vector<WallPost> posts = FitWall(grid, edges, contour);
      for (size_t i = 0; i + 1 < posts.size(); ++i) {
        for (const auto end : {&WallPost::left, &WallPost::right}) {
          const WallPost::End &from = posts[i].*end, &to = posts[i + 1].*end;
          if (from.nearness < 0.15) continue;  // the floor
          ++begins;
          EXPECT_NEAR(from.nearness, plane(from.at), 1e-6) << trial;
          const DVec2 middle = glm::mix(from.at, to.at, 0.5);
          EXPECT_NEAR(std::midpoint(from.nearness, to.nearness), plane(middle), 1e-6) << trial;
        }
      }
    }
  }
  EXPECT_GT(begins, 500u);
}

TEST(WallFitTest, SlopesHaveNoWalls) {
  const VolumeGrid grid = GridOf(MapOf(SomeView(40, 40, false), [](uint32_t x, uint32_t) {
    return static_cast<float>(1 / (0.3 - 0.00025 * x * x));  // 6 pixels' widths a pixel at most
  }));
  EdgeMap edges(grid);
  for (uint32_t x = 5; x < 30; ++x) edges.SetRight(x, 20);
  const EdgeMap kept = WallEdges(grid, edges);
  EXPECT_EQ(kept.flag_count(), 0u);
}

}  // namespace
}  // namespace penumbra
