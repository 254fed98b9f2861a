// Hierarchical traversal against every pixel that the ray passes, in double precision.
#include "render/technique/coherent_raytrace/image_traversal.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "tests/support/random_scene.h"

namespace penumbra {
namespace {

DepthMap Hills(testing::Dice& dice, bool parallel) {
  DepthMap map;
  map.view = {.from_infinity = parallel,
              .eye = parallel ? DVec3(0.2, -0.1, 0) : DVec3(0.1, 0.05, 0),
              .window = {DVec2(-1, -0.8), DVec2(1, 0.8)},
              .width = 5 + dice.Below(30),
              .height = 5 + dice.Below(30),
              .near = 0.5,
              .far = 4};
  const float a = dice.Between(0, 6), b = dice.Between(0.1f, 0.5f), c = dice.Between(0.1f, 0.5f);
  for (uint32_t y = 0; y < map.view.height; ++y) {
    for (uint32_t x = 0; x < map.view.width; ++x) {
      const float ground = 3 + 0.4f * std::sin(a + b * x) * std::cos(c * y);
      const bool is_roof = (x / 4 + y / 5) % 4 == 0;
      const float depth = is_roof ? 1.4f + 0.02f * x : ground;
      map.depths.push_back(dice.Below(12) == 0 ? kNoDepth : depth);
    }
  }
  return map;
}

struct Outcome {
  std::optional<double> blocked;  // t
  double hidden = 0;              // of t
  double margin = 1e9;            // in nearness: how close a call was
};

// Where a quantity that grows or falls all the way from `from` to `to` is `value`.
template <typename Of>
double PlaceOf(double value, const Of& of, double from, double to) {
  const bool rises = of(to) > of(from);
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (from + to);
    ((of(middle) < value) == rises ? from : to) = middle;
  }
  return from;
}

// Where the ray from t = 0 to 1 crosses the edges of pixels, in order.
template <typename At>
std::vector<double> CutsAtPixels(const LightView& view, const At& at) {
  std::vector<double> cuts{0.0, 1.0};
  for (int axis = 0; axis < 2; ++axis) {
    const uint32_t size = axis == 0 ? view.width : view.height;
    for (uint32_t edge = 0; edge <= size; ++edge) {
      if ((at(0)[axis] < edge) == (at(1)[axis] < edge)) continue;
      cuts.push_back(PlaceOf(
          edge, [&](double t) { return at(t)[axis]; }, 0, 1));
    }
  }
  std::ranges::sort(cuts);
  return cuts;
}

// x and y in pixels, nearness.
DVec3 OnImage(const DepthPyramid& image, DVec3 point) {
  const DVec3 p = image.view().Project(point);
  return {DVec2(p), image.nearness().Of(p.z)};
}

// Straight from the definition: the ray is cut at every edge of a pixel. What blocks it before
// `stands_from` does not stand.
Outcome StepByStep(const DepthPyramid& image, DVec3 origin, DVec3 way, double stands_from) {
  const LightView& view = image.view();
  const auto at = [&](double t) { return OnImage(image, origin + t * way); };
  const std::vector<double> cuts = CutsAtPixels(view, at);
  Outcome outcome;
  int side = 0;
  float last = 0;
  for (size_t i = 0; i + 1 < cuts.size(); ++i) {
    if (cuts[i + 1] - cuts[i] < 1e-9) continue;
    const DVec3 middle = at(0.5 * (cuts[i] + cuts[i + 1]));
    if (!(middle.x >= 0 && middle.y >= 0 && middle.x < view.width && middle.y < view.height)) {
      continue;
    }
    const float floor = image.At(0, int(middle.x), int(middle.y)).near;
    const double enter = at(cuts[i]).z, leave = at(cuts[i + 1]).z;
    outcome.margin = std::min({outcome.margin, std::abs(enter - floor), std::abs(leave - floor)});
    const int now = enter > floor ? 1 : -1;
    if (side != 0 && now != side && image.AreJoined(last, floor)) {
      outcome.margin = std::min(outcome.margin, std::abs(cuts[i] - stands_from));
      if (cuts[i] >= stands_from) outcome.blocked = cuts[i];
    }
    double through = cuts[i];
    if ((enter > floor) != (leave > floor)) {
      through = PlaceOf(
          floor, [&](double t) { return at(t).z; }, cuts[i], cuts[i + 1]);
      outcome.margin = std::min(outcome.margin, std::abs(through - stands_from));
      if (!outcome.blocked && floor > 0 && through >= stands_from) outcome.blocked = through;
    }
    if (outcome.blocked) return outcome;
    side = leave > floor ? 1 : -1;
    last = floor;
    if (enter < floor) outcome.hidden += (leave < floor ? cuts[i + 1] : through) - cuts[i];
    if (enter > floor && leave < floor) outcome.hidden += cuts[i + 1] - through;
  }
  return outcome;
}

// Whether it clips, and uses surfaces.
constexpr std::pair<bool, bool> kWays[] = {
    {false, false}, {false, true}, {true, false}, {true, true}};

TEST(ImageTraversalTest, FindsWhatSteppingFromPixelToPixelFinds) {
  testing::Dice dice(1);
  size_t compared = 0, blocked_rays = 0, hidden_rays = 0, passed_blocks = 0;
  for (int i = 0; i < 6000; ++i) {
    const DepthMap map = Hills(dice, i % 4 == 3);
    const DepthPyramid image(map, {.metres = dice.Between(0.05f, 0.4f)}, true);
    const DVec3 origin(dice.InCube(1).x * 2, dice.InCube(1).y * 2, dice.Between(0.8f, 3.8f));
    const DVec3 target(dice.InCube(1).x, dice.InCube(1).y, dice.Between(0.6f, 3.0f));
    const DVec3 way = target - origin;
    const double stands_from = i % 3 == 0 ? dice.Between(0, 1.2f) : 0.0;
    const Outcome expected = StepByStep(image, origin, way, stands_from);
    const ImageOrigin from(image, origin);
    const ImageRay ray(from, way);
    const WayInterval seen = ray.Clip(ray.ParametersOf({0, 1}));
    if (seen.empty() || expected.margin < 2e-5) continue;
    ++compared;
    const auto stands = [&](double s) { return ray.WayAt(s) >= stands_from; };
    for (const auto& [clips, uses_surfaces] : kWays) {
      if (uses_surfaces && stands_from > 0) continue;  // asks at about the place
      ImageTraversal traversal(clips, uses_surfaces);
      std::vector<WayInterval> hidden;
      const auto blocked = traversal.Trace(image, ray, seen, stands, hidden);
      ASSERT_EQ(blocked.has_value(), expected.blocked.has_value())
          << i << " clips " << clips << " surfaces " << uses_surfaces;
      if (blocked || uses_surfaces || clips) continue;
      passed_blocks += stands_from > 0 && StepByStep(image, origin, way, 0).blocked;
      double sum = 0;
      for (const auto& [s, e] : hidden) sum += ray.WayAt(e) - ray.WayAt(s);
      EXPECT_GE(sum, expected.hidden - 1e-4) << i;  // a pixel more at both ends
      EXPECT_EQ(hidden.empty(), expected.hidden < 1e-9) << i;
    }
    blocked_rays += expected.blocked.has_value();
    hidden_rays += expected.hidden > 0.01;
  }
  EXPECT_GT(compared, 3000u);
  EXPECT_GT(blocked_rays, 500u);
  EXPECT_GT(hidden_rays, 300u);
  EXPECT_GT(passed_blocks, 100u);
}

// Whether `count` places, evenly from a pixel and a half before t to as much after it, are all
// nearer than what the image shows; nullopt: a close call.
std::optional<bool> IsOpenAbout(const DepthPyramid& image, DVec3 origin, DVec3 way, double t,
                                int count) {
  const LightView& view = image.view();
  const DVec2 middle(OnImage(image, origin + t * way));
  double margin = 1e9;
  bool is_open = true;
  for (int k = 0; k < count; ++k) {
    const double wanted = 1.5 * (2.0 * k / (count - 1) - 1);
    const auto pixels = [&](double u) {
      const double length = glm::length(DVec2(OnImage(image, origin + u * way)) - middle);
      return u < t ? -length : length;
    };
    if (!(pixels(0) < wanted && wanted < pixels(1))) continue;
    const DVec3 p = OnImage(image, origin + PlaceOf(wanted, pixels, 0, 1) * way);
    if (!(p.x >= 0 && p.y >= 0 && p.x < view.width && p.y < view.height)) continue;
    const double above = p.z - image.At(0, int(p.x), int(p.y)).near;
    margin = std::min(margin, std::abs(above));
    is_open = is_open && above > 0;
  }
  if (margin < 1e-3) return std::nullopt;
  return is_open;
}

TEST(ImageTraversalTest, IsOpenWhereEveryPlaceWithinAPixelAndAHalfIs) {
  testing::Dice dice(3);
  size_t open = 0, closed = 0, wrong = 0;
  for (int i = 0; i < 3000; ++i) {
    const DepthPyramid image(Hills(dice, i % 4 == 3), {}, true);
    const DVec3 origin(dice.InCube(1).x * 2, dice.InCube(1).y * 2, dice.Between(0.8f, 3.8f));
    const DVec3 target(dice.InCube(1).x, dice.InCube(1).y, dice.Between(0.6f, 3.0f));
    const DVec3 way = target - origin;
    const ImageOrigin from(image, origin);
    const ImageRay ray(from, way);
    const WayInterval seen = ray.Clip(ray.ParametersOf({0, 1}));
    const double t = dice.Between(0, 1);
    const double s = ray.ParameterAt(t);
    if (!(s >= seen.from && s <= seen.to)) continue;
    const auto expected = IsOpenAbout(image, origin, way, t, 301);
    if (!expected) continue;
    ImageTraversal traversal(true, false);
    wrong += traversal.IsOpenAt(image, ray, seen, s) != *expected;
    ++(*expected ? open : closed);
  }
  EXPECT_GT(open, 300u);
  EXPECT_GT(closed, 300u);
  // A pixel's corner that the ray cuts between two of the places.
  EXPECT_LE(wrong, (open + closed) / 200) << "of " << open + closed;
}

TEST(ImageRayTest, IsTheLineThatProjectingItsPointsGives) {
  testing::Dice dice(2);
  for (int i = 0; i < 1000; ++i) {
    const DepthPyramid image(Hills(dice, i % 2 == 0), {}, true);
    const DVec3 origin(dice.InCube(1)), way(dice.InCube(2));
    const DVec3 start = origin + DVec3(0, 0, 2);
    const ImageOrigin from(image, start);
    const ImageRay ray(from, way);
    const WayInterval s = ray.ParametersOf({0.1, 0.9});
    if (s.empty()) continue;
    const double t = ray.WayAt(0.5 * (s.from + s.to));
    const DVec3 on_image = ray.start() + 0.5 * (s.from + s.to) * ray.step();
    const DVec3 expected = image.view().Project(start + t * way);
    EXPECT_NEAR(on_image.x, expected.x, 1e-6 * (1 + std::abs(expected.x)));
    EXPECT_NEAR(on_image.y, expected.y, 1e-6 * (1 + std::abs(expected.y)));
    EXPECT_NEAR(on_image.z, image.nearness().Of(expected.z), 1e-6);
  }
}

}  // namespace
}  // namespace penumbra
