// Counting by vectors against counting layer by layer, in double precision and in the world.
#include "render/technique/layered_attenuation/count_kernel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <vector>

#include "render/light_view/view_fit.h"
#include "render/technique/layered_attenuation/layer_band.h"
#include "tests/support/random_scene.h"

namespace penumbra {
namespace {

using testing::Dice;

constexpr uint32_t kSide = 12;

LightView Middle(bool from_infinity) {
  return {.from_infinity = from_infinity,
          .window = {.min = DVec2(-0.6), .max = DVec2(0.6)},
          .width = kSide,
          .height = kSide,
          .near = 1,
          .far = 3};
}

// Layers of surfaces that face the middle, a row of kSide pixels each, and what is seen of them.
struct Trial {
  LightView center, view;
  std::vector<float> nearness;  // the map's
  std::vector<uint8_t> explained;
  LayerTolerance tolerance;

  Trial(Dice& dice, bool from_infinity, bool ahead)
      : center(Middle(from_infinity)), view(center), explained(kSide * kSide + 1) {
    view.eye = DVec3(dice.Between(-0.3f, 0.3f), dice.Between(-0.3f, 0.3f),
                     ahead ? dice.Between(-0.4f, 0.4f) : 0.0f);
    view.window.min += DVec2(0.1);
    view.window.max += DVec2(0.1);
    tolerance = {.pixels = 0.5f, .width = static_cast<float>(1 / center.pixels_per_slope().x)};
    for (uint32_t p = 0; p < kSide * kSide; ++p) {
      nearness.push_back(
          NearnessOf(from_infinity, dice.Below(8) == 0 ? INFINITY : dice.Between(1, 3)));
    }
  }

  LookupMap Map() {
    return {.warp = ViewWarp(center, view),
            .nearness = nearness.data(),
            .width = kSide,
            .height = kSide,
            .from_infinity = view.from_infinity,
            .explained = explained.data()};
  }

  // Whether the map hides the point at a pixel of the middle view; nullopt where rounding or the
  // tolerance decides. `matched` becomes the pixel that sees the point.
  std::optional<bool> Hides(uint32_t column, uint32_t row, double depth) const {
    const DVec3 at = view.Project(center.PointAt(DVec2(column, row) + 0.5, depth));
    const DVec2 to_edge = glm::abs(DVec2(at) - glm::round(DVec2(at)));
    if (std::min(to_edge.x, to_edge.y) < 1e-3) return std::nullopt;
    if (at.x < 0 || at.y < 0 || at.x > kSide || at.y > kSide) return false;
    const size_t pixel = static_cast<size_t>(at.y) * kSide + static_cast<size_t>(at.x);
    const double seen = view.from_infinity ? -nearness[pixel] : 1 / double{nearness[pixel]};
    if (std::abs(seen - at.z) < 0.15) return std::nullopt;
    return seen < at.z;
  }
};

// Layers are added in turns between counting, so that vectors reach past the end of those that are
// there.
void CompareLayers(uint64_t seed, bool from_infinity, bool ahead, int& compared, int& hidden) {
  Dice dice(seed);
  Trial trial(dice, from_infinity, ahead);
  const Vec2 origin = trial.Map().warp.center_origin;
  LayerBand band(kSide, 0, kSide);
  struct Known {
    uint32_t column, row;
    double depth;
    int times;
  };
  std::vector<Known> known;
  for (int turn = 0; turn < 12; ++turn) {
    for (uint32_t i = dice.Below(7); i > 0; --i) {
      const Known layer{dice.Below(kSide), dice.Below(kSide), dice.Between(1, 3), 0};
      const Vec2 at = Vec2(static_cast<float>(layer.column), static_cast<float>(layer.row)) + 0.5f;
      const ImagePlane plane{.at = at - origin,
                             .nearness = NearnessOf(from_infinity, static_cast<float>(layer.depth)),
                             .gradient = Vec2(0)};
      const auto found =
          band.Add({layer.column, layer.row, plane}, trial.tolerance, from_infinity, 64);
      if (found == LayerBand::Found::kNew) known.push_back(layer);
    }
    ASSERT_EQ(band.size(), known.size());
    const LookupMap map = trial.Map();
    CountVisible(band.LayersFrom(0), {&map, 1}, trial.tolerance);
    for (Known& layer : known) ++layer.times;
  }
  const LayerArrays layers = band.LayersFrom(0);
  for (size_t k = 0; k < known.size(); ++k) {
    const auto hides = trial.Hides(known[k].column, known[k].row, known[k].depth);
    if (!hides) continue;
    ++compared;
    hidden += *hides;
    EXPECT_EQ(layers.count[k], *hides ? 0 : known[k].times) << "seed " << seed;
  }
}

TEST(CountKernelTest, LayersAreCountedWhereNothingIsNearer) {
  for (const bool from_infinity : {false, true}) {
    for (const bool ahead : {false, true}) {
      if (from_infinity && ahead) continue;
      int compared = 0, hidden = 0;
      for (uint64_t seed = 0; seed < 100; ++seed)
        CompareLayers(seed, from_infinity, ahead, compared, hidden);
      EXPECT_GT(compared, 1500);
      EXPECT_GT(hidden, 400);
      EXPECT_LT(hidden, compared - 400);
    }
  }
}

// A plane aslant explains each pixel of a map that sees it, and nothing behind it.
TEST(CountKernelTest, WhatALayerIsSeenInIsExplained) {
  const LightView center = Middle(false);
  LayerBand band(kSide, 0, kSide);
  const ViewWarp warp(center, center);
  const LayerTolerance tolerance{.pixels = 0.5f, .width = 0.1f};
  std::vector<float> nearness;
  for (uint32_t p = 0; p < kSide * kSide; ++p) {
    const Vec2 at = Vec2(static_cast<float>(p % kSide), static_cast<float>(p / kSide)) + 0.5f -
                    warp.center_origin;
    const ImagePlane plane{.at = at, .nearness = 0.5f + 0.01f * at.x, .gradient = {0.01f, 0}};
    nearness.push_back(p < kSide ? 0.1f : plane.nearness);  // the first row sees what is far behind
    band.Add({p % kSide, p / kSide, plane}, tolerance, false, 1);
  }
  std::vector<uint8_t> explained(kSide * kSide + 1);
  const LookupMap map{.warp = warp,
                      .nearness = nearness.data(),
                      .width = kSide,
                      .height = kSide,
                      .from_infinity = false,
                      .explained = explained.data()};
  CountVisible(band.LayersFrom(0), {&map, 1}, tolerance);
  for (uint32_t p = 0; p < kSide * kSide; ++p) {
    EXPECT_EQ(explained[p], p < kSide ? 0 : 1) << p;
    EXPECT_EQ(band.LayersFrom(0).count[p], 1) << p;
  }
}

}  // namespace
}  // namespace penumbra
