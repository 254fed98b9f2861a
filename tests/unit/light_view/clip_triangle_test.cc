#include "render/light_view/clip_triangle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/support/random_scene.h"

namespace penumbra {
namespace {

constexpr double kNear = 0.5, kReach = 100;

std::array<ClipCorner, 3> RandomCorners(testing::Dice& dice) {
  std::array<ClipCorner, 3> corners;
  for (ClipCorner& corner : corners) {
    const double w = dice.Between(-1, 3);
    corner.place = DVec3(dice.Between(-300, 300), dice.Between(-300, 300), w);
  }
  return corners;
}

double Cross(DVec2 a, DVec2 b) { return a.x * b.y - a.y * b.x; }

// Whether a point of the image is in a polygon that turns either way; nullopt at its edges.
std::optional<bool> Holds(const ClippedTriangle& polygon, DVec2 p) {
  int left = 0, right = 0;
  for (size_t i = 0; i < polygon.count; ++i) {
    const DVec2 a(polygon.corners[i].at), b(polygon.corners[(i + 1) % polygon.count].at);
    const double side = Cross(b - a, p - a);
    if (std::abs(side) < 1e-2) {
      if (glm::distance(a, b) > 1e-3) return std::nullopt;
      continue;
    }
    (side > 0 ? left : right)++;
  }
  return left == 0 || right == 0;
}

// A pixel sees the triangle where p = Σ λ_k p_k / w with all λ_k ≥ 0, and at 1/Σ λ_k.
TEST(ClipTriangleTest, KeepsJustWhatIsBeyondTheNearPlane) {
  size_t inside = 0, outside = 0;
  for (uint64_t seed = 0; seed < 2'000; ++seed) {
    testing::Dice dice(seed);
    const auto corners = RandomCorners(dice);
    const ClippedTriangle polygon = ClipTriangle(corners, kNear, kReach);
    const glm::dmat3 of_corners(corners[0].place, corners[1].place, corners[2].place);
    if (std::abs(glm::determinant(of_corners)) < 1) continue;
    for (int i = 0; i < 20; ++i) {
      const DVec2 p(dice.Between(-99, 99), dice.Between(-99, 99));
      const DVec3 shares = glm::inverse(of_corners) * DVec3(p, 1);
      const double depth = 1 / (shares.x + shares.y + shares.z);
      const double least = std::min({shares.x, shares.y, shares.z});
      if (std::abs(least * depth) < 1e-3 || std::abs(depth - kNear) < 1e-2) continue;
      const bool expected = least > 0 && depth > kNear;
      const auto held = polygon.count < 3 ? std::optional(false) : Holds(polygon, p);
      if (!held) continue;
      EXPECT_EQ(*held, expected) << "seed " << seed << " point " << p.x << ' ' << p.y;
      (expected ? inside : outside)++;
    }
  }
  EXPECT_GT(inside, 500u);
  EXPECT_GT(outside, 5'000u);
}

TEST(ClipTriangleTest, EveryCornerIsWithinReach) {
  for (uint64_t seed = 0; seed < 2'000; ++seed) {
    testing::Dice dice(seed);
    const ClippedTriangle polygon = ClipTriangle(RandomCorners(dice), kNear, kReach);
    for (size_t i = 0; i < polygon.count; ++i) {
      const Vec2 at = glm::abs(polygon.corners[i].at);
      EXPECT_LE(std::max(at.x, at.y), 100.0f);
    }
  }
}

// Two triangles beside one edge, whichever way each goes along it.
TEST(ClipTriangleTest, NeighboursAreCutAtTheSamePlaces) {
  size_t shared = 0;
  for (uint64_t seed = 0; seed < 2'000; ++seed) {
    testing::Dice dice(seed);
    const auto one = RandomCorners(dice);
    const std::array other{one[1], one[0], RandomCorners(dice)[0]};
    const auto on_edge = [&](const ClippedTriangle& polygon) {
      std::vector<std::pair<float, float>> places;
      const DVec3 line = glm::cross(one[0].place, one[1].place);
      for (size_t i = 0; i < polygon.count; ++i) {
        const DVec3 p = polygon.corners[i].place;
        if (std::abs(glm::dot(line, p)) > 1e-9 * glm::length(line) * glm::length(p)) continue;
        places.emplace_back(polygon.corners[i].at.x, polygon.corners[i].at.y);
      }
      std::ranges::sort(places);
      return places;
    };
    const auto a = on_edge(ClipTriangle(one, kNear, kReach));
    const auto b = on_edge(ClipTriangle(other, kNear, kReach));
    if (a.size() != 2 || b.size() != 2) continue;
    EXPECT_EQ(a, b) << "seed " << seed;
    ++shared;
  }
  EXPECT_GT(shared, 200u);
}

TEST(ClipTriangleTest, CornersThatArePlacedStayWhereTheyAre) {
  std::array<ClipCorner, 3> corners;
  corners[0] = {.place = DVec3(0, 0, 1), .at = Vec2(0.25f, 0), .is_placed = true};
  corners[1] = {.place = DVec3(10, 0, 1), .at = Vec2(10.25f, 0), .is_placed = true};
  corners[2] = {.place = DVec3(0, 10, -1)};
  const ClippedTriangle polygon = ClipTriangle(corners, kNear, kReach);
  ASSERT_EQ(polygon.count, 4u);
  EXPECT_EQ(polygon.corners[0].at, Vec2(0.25f, 0));
  EXPECT_EQ(polygon.corners[1].at, Vec2(10.25f, 0));
  EXPECT_EQ(polygon.corners[2].at, Vec2(15, 5)) << "½ deep a quarter of the way to the third";
}

}  // namespace
}  // namespace penumbra
