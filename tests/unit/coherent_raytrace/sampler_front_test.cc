// Sampling with predictions against sampling without.
#include "render/technique/coherent_raytrace/sampler_front.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <vector>

#include "render/technique/coherent_raytrace/light_proof.h"
#include "tests/support/random_scene.h"
#include "tests/support/shapes.h"

namespace penumbra {
namespace {

// Blocks what `blocks` says of each ray's way through the plane y = height.
class PlaneTracer : public ShadowTracer {
 public:
  using Blocks = std::function<bool(Vec2 xz)>;
  PlaneTracer(float height, Blocks blocks) : height_(height), blocks_(std::move(blocks)) {}

  void Trace(const ShadowRays& rays, std::span<float> blocked_at,
             TraceCounts& counts) const override {
    size_t i = 0;
    for (const RayFan& fan : rays.fans) {
      const Vec3 from = fan.from.position;
      for (; i < fan.end; ++i) {
        const Vec3 target(rays.x[i], rays.y[i], rays.z[i]);
        const Vec3 way = rays.at_infinity ? target : target - from;
        const float t = (height_ - from.y) / way.y;
        const Vec3 at = from + t * way;
        blocked_at[i] = t > 0 && blocks_({at.x, at.z}) ? t : kUnblocked;
      }
    }
    EXPECT_EQ(i, rays.x.size());
    counts.rays += rays.x.size();
  }

 private:
  const float height_;
  const Blocks blocks_;
};

const AreaLight kLamp{.id = "lamp",
                      .shape = RectangleLight{.corner = {-0.5f, 2, -0.5f}, .two_sided = true}};

CellMask VisibleFrom(SamplerFront& front, const SurfacePoint& point, uint64_t index,
                     uint32_t lane = 0) {
  front.Begin(lane, point, index);
  front.Finish();
  return front.visible(lane);
}

SurfacePoint OnALine(int i) { return {{-2 + 0.01f * static_cast<float>(i), 0, 0.1f}, {0, 1, 0}}; }

std::vector<CellMask> AlongALine(const AreaLight& light, const ShadowTracer& tracer,
                                 const SamplingSettings& settings, double* mean_rays = nullptr) {
  const LightSquare square(light);
  const auto front = MakeSamplerFront(square, tracer, settings, nullptr);
  std::vector<CellMask> seen;
  for (int i = 0; i < 400; ++i) seen.push_back(VisibleFrom(*front, OnALine(i), i));
  if (mean_rays) *mean_rays = double(front->TakeCounts().rays) / 400;
  return seen;
}

const PlaneTracer kHalfPlane(1.0f, [](Vec2 at) { return at.x < 0.05f; });
const PlaneTracer kStripes(1.0f, [](Vec2 at) { return std::sin(9 * at.x + 4 * at.y) > 0.4f; });

TEST(SamplerFrontTest, FindsThePenumbraOfAHalfPlane) {
  for (const bool predicts : {false, true}) {
    double rays = 0;
    const auto seen = AlongALine(
        kLamp, kHalfPlane, {.side = 16, .predicts = predicts, .prediction_distance = 0.04f}, &rays);
    for (int i = 0; i < 400; ++i) {
      // The edge at height 1 of 2 falls on the lamp at 2 · 0.05 − x.
      const double x = -2 + 0.01 * i;
      const double share = std::clamp(0.5 - (0.1 - x), 0.0, 1.0);
      EXPECT_NEAR(seen[i].Count() / 256.0, share, 1.0 / 16) << i;
    }
    if (predicts) {
      EXPECT_LT(rays, 90);
    } else {
      EXPECT_EQ(rays, 256);
    }
  }
}

TEST(SamplerFrontTest, WithoutShortcutsWhatIsTracedIsExact) {
  const auto full = AlongALine(kLamp, kStripes, {.side = 16, .predicts = false});
  size_t differ = 0;
  const auto coherent = AlongALine(
      kLamp, kStripes,
      {.side = 16, .skips_known_rays = false, .exterior_turns = 1, .prediction_distance = 0.04f});
  for (int i = 0; i < 400; ++i) {
    differ += ((full[i] - coherent[i]) | (coherent[i] - full[i])).Count();
  }
  EXPECT_LE(differ, 400u * 256 / 1000);
}

TEST(SamplerFrontTest, ShortcutsCostLittle) {
  const auto full = AlongALine(kLamp, kStripes, {.side = 16, .predicts = false});
  const auto coherent = AlongALine(kLamp, kStripes, {.side = 16, .prediction_distance = 0.04f});
  double sum2 = 0;
  for (int i = 0; i < 400; ++i) {
    const double off = (double(full[i].Count()) - coherent[i].Count()) / 256;
    sum2 += off * off;
  }
  EXPECT_LT(std::sqrt(sum2 / 400), 0.025);
}

TEST(SamplerFrontTest, BeyondTheDistanceNothingIsPredicted) {
  double rays = 0;
  const auto coherent =
      AlongALine(kLamp, kStripes, {.side = 8, .prediction_distance = 0.005f}, &rays);
  EXPECT_EQ(coherent, AlongALine(kLamp, kStripes, {.side = 8, .predicts = false}));
  EXPECT_EQ(rays, 64);
}

TEST(SamplerFrontTest, WhatIsProvenLitCostsNoRay) {
  // Under a post that hides some of the lamp.
  SceneDelta delta;
  delta.upsert_instances = {{.id = "post",
                             .mesh = testing::MeshOf(testing::UnitBoxGeometry()),
                             .world_from_mesh = testing::Placed(Vec3(-0.3f, 1, 0), 0.1f)},
                            {.id = "floor",
                             .mesh = testing::MeshOf(testing::UnitSquareGeometry()),
                             .world_from_mesh = testing::Placed(Vec3(0), 4.0f)}};
  delta.upsert_lights = {kLamp};
  const auto scene = Scene::Empty("s")->Apply(delta).value();
  tbb::task_arena arena(1);
  const LightProof proof(kLamp, *scene, {.pixels = 512}, arena);
  const LightSquare square(kLamp);
  const PlaneTracer open(1.0f, [](Vec2) { return false; });
  const auto front = MakeSamplerFront(square, open, {.side = 8}, &proof);
  EXPECT_EQ(VisibleFrom(*front, {{1, 0, 0.5f}, {0, 1, 0}}, 0), CellMask::All(8));
  EXPECT_EQ(front->rays(0), 0u);
  const SurfacePoint below{{0, 0, 0}, {0, 1, 0}};
  EXPECT_EQ(VisibleFrom(*front, below, 1), CellMask::All(8));
  EXPECT_EQ(front->rays(0), 64 - proof.LitFrom(below, 8).Count());
  EXPECT_LE(front->rays(0), 48u);
  EXPECT_GT(front->rays(0), 0u);
}

TEST(SamplerFrontTest, WhatIsBehindCostsNoRay) {
  const PlaneTracer open(1.0f, [](Vec2) { return false; });
  AreaLight lamp = kLamp;
  std::get<RectangleLight>(lamp.shape).two_sided = false;  // its front, u × v, is down
  const LightSquare square(lamp);
  const auto front = MakeSamplerFront(square, open, {.side = 16}, nullptr);
  EXPECT_TRUE(VisibleFrom(*front, {{0, 3, 0}, {0, -1, 0}}, 0).empty()) << "at its back";
  EXPECT_TRUE(VisibleFrom(*front, {{0, 0, 0}, {0, -1, 0}}, 1).empty()) << "below horizon";
  EXPECT_EQ(front->TakeCounts().rays, 0u);
  // The plane x = 0 halves the lamp.
  const CellMask half = VisibleFrom(*front, {{0, 0, 0}, {1, 0, 0}}, 2);
  EXPECT_EQ(half.Count(), 128u);
  EXPECT_EQ(front->TakeCounts().rays, 128u);
}

// Side by side, or each by itself: rows too far apart to continue from each other do not notice
// each other, however many rays are traced at a time.
TEST(SamplerFrontTest, RowsTogetherSeeWhatTheySeeAlone) {
  constexpr uint32_t kRows = SamplerFront::kLanes, kColumns = 60;
  const LightSquare square(kLamp);
  const auto point = [](uint32_t row, uint32_t column) {
    return SurfacePoint{
        {-0.3f + 0.01f * static_cast<float>(column), 0, 0.1f * static_cast<float>(row)}, {0, 1, 0}};
  };
  for (const uint32_t side : {1u, 8u, 16u, 32u}) {
    const SamplingSettings settings{
        .side = side, .exterior_turns = 3, .prediction_distance = 0.04f};
    const auto together = MakeSamplerFront(square, kStripes, settings, nullptr);
    std::vector<std::unique_ptr<SamplerFront>> alone;
    for (uint32_t row = 0; row < kRows; ++row) {
      alone.push_back(MakeSamplerFront(square, kStripes, settings, nullptr));
    }
    for (uint32_t column = 0; column < kColumns; ++column) {
      for (uint32_t row = kRows; row-- > 0;) {
        together->Begin(row, point(row, column), row * kColumns + column);
      }
      together->Finish();
      for (uint32_t row = 0; row < kRows; ++row) {
        const uint64_t index = row * kColumns + column;
        ASSERT_EQ(together->visible(row), VisibleFrom(*alone[row], point(row, column), index));
        ASSERT_EQ(together->rays(row), alone[row]->rays(0));
      }
    }
  }
}

// Its first point is new to a row, but next to the last of the row above.
TEST(SamplerFrontTest, ARowBeginsWithWhatTheRowAboveKnows) {
  const LightSquare square(kLamp);
  const auto front =
      MakeSamplerFront(square, kHalfPlane, {.side = 16, .prediction_distance = 0.04f}, nullptr);
  VisibleFrom(*front, OnALine(190), 0, 4);
  EXPECT_EQ(front->rays(4), 256u);
  VisibleFrom(*front, OnALine(191), 1, 5);
  EXPECT_LT(front->rays(5), 128u);
  VisibleFrom(*front, OnALine(192), 2, 7);
  EXPECT_EQ(front->rays(7), 256u) << "no row above";
  front->Restart();
  VisibleFrom(*front, OnALine(193), 3, 5);
  EXPECT_EQ(front->rays(5), 256u) << "all forgotten";
}

// More than a batch of rays at a time.
TEST(SamplerFrontTest, AllCellsOfAllLanesAtOnce) {
  const PlaneTracer blocks_all(1.0f, [](Vec2) { return true; });
  const LightSquare square(kLamp);
  for (const uint32_t side : {31u, 32u}) {
    const auto front = MakeSamplerFront(square, blocks_all, {.side = side}, nullptr);
    for (uint32_t lane = SamplerFront::kLanes; lane-- > 0;) {
      front->Begin(lane, OnALine(static_cast<int>(8 * lane)), lane);
    }
    front->Finish();
    EXPECT_EQ(front->TakeCounts().rays, uint64_t{SamplerFront::kLanes} * side * side);
    for (uint32_t lane = 0; lane < SamplerFront::kLanes; ++lane) {
      EXPECT_TRUE(front->visible(lane).empty());
      EXPECT_EQ(front->rays(lane), side * side);
    }
  }
}

// At every turn another part of the light's edge, at last all of it.
TEST(SamplerFrontTest, TheLightsEdgeIsTracedInTurns) {
  const PlaneTracer open(1.0f, [](Vec2) { return false; });
  const LightSquare square(kLamp);
  for (const uint32_t turns : {1u, 2u, 5u, 8u}) {
    const auto front = MakeSamplerFront(
        square, open, {.side = 16, .exterior_turns = turns, .prediction_distance = 1}, nullptr);
    VisibleFrom(*front, OnALine(0), 0);
    uint32_t rays = 0;
    for (uint32_t turn = 0; turn < turns; ++turn) {
      VisibleFrom(*front, OnALine(1), 1 + turn);
      EXPECT_GE(front->rays(0), 60 / turns - 4);
      EXPECT_LE(front->rays(0), 60 / turns + 4);
      rays += front->rays(0);
    }
    EXPECT_EQ(rays, 60u);
  }
}

TEST(SamplerFrontTest, PointsOnTheLightAndOddNumbersAreHarmless) {
  const PlaneTracer open(1.0f, [](Vec2) { return false; }), dense(1.0f, [](Vec2) { return true; });
  testing::Dice dice(1);
  for (int kind = 0; kind < testing::kLightKinds; ++kind) {
    const AreaLight light = testing::RandomLight(dice, kind);
    const LightSquare square(light);
    const uint32_t side = square.is_single() ? 1 : 5;
    const SamplingSettings settings{.side = side, .prediction_distance = 10};
    for (const PlaneTracer* tracer : {&open, &dense}) {
      const auto front = MakeSamplerFront(square, *tracer, settings, nullptr);
      const LightSquare::Seen seen = square.From(Vec3(0));
      for (const Vec3 p :
           {seen.TargetAt({0.5f, 0.5f}), seen.TargetAt({0, 0}), Vec3(NAN), Vec3(1e30f)}) {
        EXPECT_LE(VisibleFrom(*front, {p, {0, 1, 0}}, 0).Count(), side * side);
        EXPECT_LE(front->rays(0), side * side);
      }
      front->Restart();
      const auto fresh = MakeSamplerFront(square, *tracer, settings, nullptr);
      EXPECT_EQ(VisibleFrom(*front, OnALine(5), 5), VisibleFrom(*fresh, OnALine(5), 5));
    }
  }
}

}  // namespace
}  // namespace penumbra
