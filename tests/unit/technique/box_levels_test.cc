// What is left out by its box could not have cast: against the map itself, point by point.
#include "render/technique/soft_texture/box_levels.h"

#include "gtest/gtest.h"
#include "tests/support/random_scene.h"

namespace penumbra::testing {
namespace {

struct Case {
  Parallelogram patch;
  LightSample sample;
  TexelWindow window;
  uint32_t height;
};

Case RandomCase(Dice& dice) {
  Case c;
  c.patch = {.origin = dice.InCube(2),
             .edge_u = dice.Between(0.5f, 4) * dice.Direction(),
             .edge_v = dice.Between(0.5f, 4) * dice.Direction()};
  c.sample.at_infinity = dice.Below(4) == 0;
  c.sample.point = c.sample.at_infinity ? dice.Direction() : dice.Between(1, 6) * dice.Direction();
  c.height = 1 + dice.Below(100);
  const uint32_t begin = dice.Below(c.height);
  c.window = {.width = 1 + dice.Below(100),
              .row_begin = begin,
              .row_end = begin + 1 + dice.Below(c.height - begin)};
  return c;
}

// Neighbours one after another, as pieces are.
std::vector<Aabb> RandomBoxes(Dice& dice, int count) {
  std::vector<Aabb> boxes;
  Vec3 at = dice.InCube(3);
  for (int b = 0; b < count; ++b) {
    at = b % 16 == 0 ? dice.InCube(3) : at + dice.InCube(0.3f);
    Aabb& box = boxes.emplace_back();
    const Vec3 half = glm::abs(dice.InCube(dice.Below(3) == 0 ? 0.01f : 0.6f));
    box.Add(at - half);
    box.Add(at + half);
  }
  return boxes;
}

// Whether a shadow of the point falls between the window's first and last row, on the texture.
bool CastsOnto(DVec3 offset, const ReceiverTransform& map, const Case& c) {
  const DVec3 p = map.FromOffset(offset);
  const double row = c.height * p.y;
  return p.z > 0 && p.x >= 0 && p.x <= p.z && row >= c.window.row_begin * p.z &&
         row <= c.window.row_end * p.z;
}

TEST(BoxLevelsTest, NothingThatCastsIsLeftOut) {
  Dice dice(3);
  int left_out = 0, casting = 0, idle = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const Case c = RandomCase(dice);
    const auto map = ReceiverTransform::Create(c.patch, c.sample, 1e-6);
    if (!map) continue;
    const std::vector<Aabb> boxes = RandomBoxes(dice, 1 + static_cast<int>(dice.Below(600)));
    const UnitBoxSides sides(*map, c.window, c.height);
    std::vector<uint32_t> found;
    BoxLevels(boxes).Select(sides, found);
    std::vector<bool> is_found(boxes.size());
    for (const uint32_t b : found) is_found[b] = true;
    for (size_t b = 0; b < boxes.size(); ++b) {
      bool casts = false;
      for (int i = 0; i < 60; ++i) {
        // Corners and faces above all: that is where a box reaches furthest.
        DVec3 t(dice.Between(-0.5f, 1.5f), dice.Between(-0.5f, 1.5f), dice.Between(-0.5f, 1.5f));
        t = glm::clamp(t, DVec3(0.0), DVec3(1.0));
        casts = casts || CastsOnto(glm::mix(DVec3(boxes[b].min), DVec3(boxes[b].max), t), *map, c);
      }
      ASSERT_TRUE(is_found[b] || !casts) << "trial " << trial << ", box " << b;
      ASSERT_TRUE(!is_found[b] || !MissesUnitBox(boxes[b], sides)) << trial << ", box " << b;
      left_out += !is_found[b];
      casting += casts;
      idle += is_found[b] && !casts;
    }
  }
  EXPECT_GT(casting, 2000);
  EXPECT_GT(left_out, 50'000);
  // What is found in vain: boxes beside a corner, or met between the points that were tried.
  EXPECT_LT(idle, 0.2 * (left_out + casting));
}

TEST(BoxLevelsTest, BoxesThatTouchASideAreKept) {
  const Parallelogram patch{.origin = Vec3(0), .edge_u = Vec3(3, 0, 0), .edge_v = Vec3(0, 0, -3)};
  const LightSample above{.point = Vec3(0, 1, 0), .at_infinity = true};
  const auto map = ReceiverTransform::Create(patch, above, 1e-6);
  const UnitBoxSides sides(*map, {.width = 8, .row_begin = 0, .row_end = 8}, 8);
  const auto keeps = [&](Vec3 low, Vec3 high) {
    std::vector<uint32_t> found;
    const std::vector<Aabb> boxes = {{low, high}};
    BoxLevels(boxes).Select(sides, found);
    return !found.empty();
  };
  EXPECT_TRUE(keeps({-1, 1, -2}, {0, 2, -1}));
  EXPECT_FALSE(keeps({-1, 1, -2}, {-0.001f, 2, -1}));
  EXPECT_TRUE(keeps({3, 1, -2}, {4, 2, -1}));
  EXPECT_FALSE(keeps({3.001f, 1, -2}, {4, 2, -1}));
  EXPECT_TRUE(keeps({1, 1, 0}, {2, 2, 1}));
  EXPECT_FALSE(keeps({1, 1, 0.001f}, {2, 2, 1}));
  EXPECT_FALSE(keeps({1, 1, -5}, {2, 2, -3.001f}));
}

TEST(BoxLevelsTest, OfNoBoxesNoneIsFound) {
  const auto map = ReceiverTransform::Create({}, {.point = Vec3(0, 2, 0)}, 1e-6);
  std::vector<uint32_t> found = {7};
  BoxLevels().Select(UnitBoxSides(*map, {.width = 1, .row_begin = 0, .row_end = 1}, 1), found);
  EXPECT_TRUE(found.empty());
}

}  // namespace
}  // namespace penumbra::testing
