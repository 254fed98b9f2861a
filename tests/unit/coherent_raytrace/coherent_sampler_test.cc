// Sampling with predictions against sampling without.
#include "render/technique/coherent_raytrace/coherent_sampler.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "tests/support/random_scene.h"

namespace penumbra {
namespace {

// Blocks what `blocks` says of each ray's way through the plane y = height.
class PlaneTracer : public ShadowTracer {
 public:
  using Blocks = std::function<bool(Vec2 xz)>;
  PlaneTracer(float height, Blocks blocks) : height_(height), blocks_(std::move(blocks)) {}

  void Trace(const ShadowRays& rays, std::span<float> blocked_at,
             TraceCounts& counts) const override {
    for (size_t i = 0; i < rays.x.size(); ++i) {
      const Vec3 target(rays.x[i], rays.y[i], rays.z[i]), from = rays.from.position;
      const Vec3 way = rays.at_infinity ? target : target - from;
      const float t = (height_ - from.y) / way.y;
      const Vec3 at = from + t * way;
      blocked_at[i] = t > 0 && blocks_({at.x, at.z}) ? t : kUnblocked;
    }
    counts.rays += rays.x.size();
  }

 private:
  const float height_;
  const Blocks blocks_;
};

const AreaLight kLamp{.id = "lamp",
                      .shape = RectangleLight{.corner = {-0.5f, 2, -0.5f}, .two_sided = true}};

std::vector<CellMask> AlongALine(const AreaLight& light, const ShadowTracer& tracer,
                                 const SamplingSettings& settings, double* mean_rays = nullptr) {
  const LightSquare square(light);
  CoherentSampler sampler(square, tracer, settings);
  std::vector<CellMask> seen;
  for (int i = 0; i < 400; ++i) {
    const SurfacePoint point{{-2 + 0.01f * i, 0, 0.1f}, {0, 1, 0}};
    seen.push_back(sampler.Visible(point, i, {CellMask(settings.side), CellMask(settings.side)}));
  }
  if (mean_rays) *mean_rays = double(sampler.counts().rays) / 400;
  return seen;
}

const PlaneTracer kHalfPlane(1.0f, [](Vec2 at) { return at.x < 0.05f; });
const PlaneTracer kStripes(1.0f, [](Vec2 at) { return std::sin(9 * at.x + 4 * at.y) > 0.4f; });

TEST(CoherentSamplerTest, FindsThePenumbraOfAHalfPlane) {
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
    }
    if (!predicts) {
      EXPECT_EQ(rays, 256);
    }
  }
}

TEST(CoherentSamplerTest, WithoutShortcutsWhatIsTracedIsExact) {
  const auto full = AlongALine(kLamp, kStripes, {.side = 16, .predicts = false});
  size_t differ = 0;
  const auto coherent = AlongALine(kLamp, kStripes,
                                   {.side = 16,
                                    .skips_known_rays = false,
                                    .alternates_exterior = false,
                                    .prediction_distance = 0.04f});
  for (int i = 0; i < 400; ++i) {
    differ += ((full[i] - coherent[i]) | (coherent[i] - full[i])).Count();
  }
  EXPECT_LE(differ, 400u * 256 / 1000);
}

TEST(CoherentSamplerTest, ShortcutsCostLittle) {
  const auto full = AlongALine(kLamp, kStripes, {.side = 16, .predicts = false});
  const auto coherent = AlongALine(kLamp, kStripes, {.side = 16, .prediction_distance = 0.04f});
  double sum2 = 0;
  for (int i = 0; i < 400; ++i) {
    const double off = (double(full[i].Count()) - coherent[i].Count()) / 256;
    sum2 += off * off;
  }
  EXPECT_LT(std::sqrt(sum2 / 400), 0.025);
}

TEST(CoherentSamplerTest, BeyondTheDistanceNothingIsPredicted) {
  double rays = 0;
  const auto coherent =
      AlongALine(kLamp, kStripes, {.side = 8, .prediction_distance = 0.005f}, &rays);
  EXPECT_EQ(coherent, AlongALine(kLamp, kStripes, {.side = 8, .predicts = false}));
  EXPECT_EQ(rays, 64);
}

TEST(CoherentSamplerTest, KnownCellsCostNoRay) {
  const LightSquare square(kLamp);
  CoherentSampler sampler(square, kHalfPlane, {.side = 8, .prediction_distance = 1});
  const SurfacePoint point{Vec3(0), {0, 1, 0}};
  const CellMask left = CellMask::Block(8, 0, 0, 4, 8), right = CellMask::All(8) - left;
  EXPECT_EQ(sampler.Visible(point, 0, {left, right}), left);
  EXPECT_EQ(sampler.Visible(point, 1, {CellMask::All(8), CellMask(8)}), CellMask::All(8));
  EXPECT_EQ(sampler.counts().rays, 0u);
  // The other half of the light, none of which was known at the point before.
  sampler.Restart();
  sampler.Visible(point, 2, {left, CellMask(8)});
  EXPECT_EQ(sampler.counts().rays, 32u);
}

TEST(CoherentSamplerTest, WhatIsBehindCostsNoRay) {
  const PlaneTracer open(1.0f, [](Vec2) { return false; });
  AreaLight lamp = kLamp;
  std::get<RectangleLight>(lamp.shape).two_sided = false;  // its front, u × v, is down
  const LightSquare square(lamp);
  CoherentSampler sampler(square, open, {.side = 16});
  const KnownCells nothing{CellMask(16), CellMask(16)};
  EXPECT_TRUE(sampler.Visible({{0, 3, 0}, {0, -1, 0}}, 0, nothing).empty()) << "at its back";
  EXPECT_TRUE(sampler.Visible({{0, 0, 0}, {0, -1, 0}}, 1, nothing).empty()) << "below horizon";
  EXPECT_EQ(sampler.counts().rays, 0u);
  // The plane x = 0 halves the lamp.
  const CellMask half = sampler.Visible({{0, 0, 0}, {1, 0, 0}}, 2, nothing);
  EXPECT_EQ(half.Count(), 128u);
  EXPECT_EQ(sampler.counts().rays, 128u);
}

TEST(CoherentSamplerTest, PointsOnTheLightAndOddNumbersAreHarmless) {
  const PlaneTracer open(1.0f, [](Vec2) { return false; });
  testing::Dice dice(1);
  for (int kind = 0; kind < testing::kLightKinds; ++kind) {
    const AreaLight light = testing::RandomLight(dice, kind);
    const LightSquare square(light);
    const uint32_t side = square.is_single() ? 1 : 5;
    CoherentSampler sampler(square, open, {.side = side, .prediction_distance = 10});
    const KnownCells nothing{CellMask(side), CellMask(side)};
    const LightSquare::Seen seen = square.From(Vec3(0));
    for (const Vec3 p :
         {seen.TargetAt({0.5f, 0.5f}), seen.TargetAt({0, 0}), Vec3(NAN), Vec3(1e30f)}) {
      EXPECT_LE(sampler.Visible({p, {0, 1, 0}}, 0, nothing).Count(), side * side);
    }
  }
}

// Even in each cell, and between neighbours without relation.
TEST(PointSamplesTest, FillTheirCellsAndAreDecorrelated) {
  double sum = 0, sum2 = 0, product = 0;
  constexpr int kPoints = 2000;
  PointSamples samples, next;
  for (int i = 0; i < kPoints; ++i) {
    samples.Place({4, 3}, 9, i);
    next.Place({4, 3}, 9, i + 1);
    for (uint32_t y = 0; y < 4; ++y) {
      for (uint32_t x = 0; x < 4; ++x) {
        const uint32_t cell = 32 * y + x;
        const double u = 4 * samples.u[cell] - x, v = 4 * samples.v[cell] - y;
        ASSERT_TRUE(u >= 0 && u < 1 && v >= 0 && v < 1);
        EXPECT_EQ(samples.part[cell], int(3 * (y + v)) * 12 + int(3 * (x + u)));
        sum += u + v, sum2 += u * u + v * v;
        product += (u - 0.5) * (v - 0.5) + (u - 0.5) * (4 * next.u[cell] - x - 0.5) +
                   (u - 0.5) * (4 * samples.u[32 * y + (x + 1) % 4] - (x + 1) % 4 - 0.5);
      }
    }
  }
  const double n = 16.0 * kPoints;
  EXPECT_NEAR(sum / (2 * n), 0.5, 0.005);
  EXPECT_NEAR(sum2 / (2 * n), 1.0 / 3, 0.005);
  EXPECT_NEAR(product / n, 0.0, 0.005);
}

}  // namespace
}  // namespace penumbra
