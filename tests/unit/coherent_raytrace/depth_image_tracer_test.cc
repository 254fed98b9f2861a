// Rays through depth images: the same whatever is left out, close to rays against triangles.
#include "render/technique/coherent_raytrace/depth_image_tracer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "render/light_view/raster_depth_source.h"
#include "render/scene/field_error.h"
#include "render/technique/coherent_raytrace/reference_images.h"
#include "render/technique/coherent_raytrace/triangle_tracer.h"
#include "tests/unit/coherent_raytrace/ray_batch.h"

namespace penumbra {
namespace {

using testing::Batch;
using testing::RandomBatch;

// Each acceleration by itself, all of them, and none with the images from the last to the first.
std::vector<DepthImageTracer> OtherWays(const std::vector<DepthPyramid>& images) {
  const RayAccelerations none = RayAccelerations::None();
  std::vector<DepthImageTracer> ways;
  for (bool RayAccelerations::*const one :
       {&RayAccelerations::connectedness, &RayAccelerations::min_max_clipping,
        &RayAccelerations::ranking, &RayAccelerations::clear_miss,
        &RayAccelerations::occlusion_intervals}) {
    RayAccelerations some = none;
    some.*one = true;
    ways.emplace_back(images, some);
  }
  ways.emplace_back(images, RayAccelerations{});
  ways.emplace_back(std::vector(images.rbegin(), images.rend()), none);
  return ways;
}

TEST(DepthImageTracerTest, NeitherSwitchesNorTheOrderOfImagesChangeWhatIsBlocked) {
  CasterBvhs bvhs;
  tbb::task_arena arena(2);
  size_t rays = 0, wrong = 0, differ = 0;
  for (uint64_t seed = 0; seed < 36; ++seed) {
    testing::Dice dice(seed);
    const auto scene = testing::RandomScene(seed);
    const AreaLight& light = *scene->FindLight("light");
    RasterDepthSource source(*scene, arena);
    const auto images = DrawReferenceImages(light, *scene, {.pixels = 512}, source, arena);
    ASSERT_TRUE(images.ok()) << images.status();
    const LightSquare square(light);
    const TriangleTracer triangles(bvhs.Flat(*scene), SurfaceOffset(scene->Bounds()));
    const DepthImageTracer plain(*images, RayAccelerations::None());
    const std::vector<DepthImageTracer> others = OtherWays(*images);
    for (int i = 0; i < 40; ++i) {
      const Batch batch = RandomBatch(dice, square, 8);
      const auto truth = batch.Trace(triangles, false), slow = batch.Trace(plain, true);
      for (size_t k = 0; k < truth.size(); ++k) {
        wrong += (truth[k] == kUnblocked) != (slow[k] == kUnblocked);
      }
      for (const DepthImageTracer& other : others) {
        const auto answers = batch.Trace(other, false);
        for (size_t k = 0; k < truth.size(); ++k) {
          differ += (answers[k] == kUnblocked) != (slow[k] == kUnblocked);
        }
      }
      rays += truth.size();
    }
  }
  // Random scenes are full of what depth images show badly: points inside of things, slivers.
  EXPECT_LE(wrong, rays / 40) << "of " << rays;
  // Rays that graze a surface: places are known within rounding, of one surface within the node.
  EXPECT_LE(differ, rays / 1000) << "of 7 times " << rays;
}

// A floor 3 m below the light, and above it a blade as wide as three pixels.
DepthPyramid BladeSeenFrom(double eye_x, bool shows_blade) {
  DepthMap map;
  map.view = {.eye = DVec3(eye_x, 0, 0),
              .window = {DVec2(-1), DVec2(1)},
              .width = 64,
              .height = 64,
              .near = 0.5,
              .far = 4};
  const int middle = static_cast<int>(map.view.Project(DVec3(0, 0, 2)).x);
  for (int i = 0; i < 64 * 64; ++i) {
    const bool is_blade = std::abs(i % 64 - middle) <= 1;
    map.depths.push_back(shows_blade && is_blade ? 2.0f : 3.0f);
  }
  return DepthPyramid(map, {}, /*covers_all=*/true);
}

TEST(DepthImageTracerTest, WhatOneImageSeesToBeEmptyIsEmpty) {
  Batch batch{.from = {Vec3(0, 0, 2.95f), Vec3(0, 0, -1)}, .at_infinity = false};
  batch.x = {0.05f}, batch.y = {0.1f}, batch.z = {0};
  const auto is_blocked = [&](std::vector<DepthPyramid> images, const RayAccelerations& how) {
    const DepthImageTracer tracer(std::move(images), how);
    return batch.Trace(tracer, true)[0] != kUnblocked;
  };
  for (const RayAccelerations& how : {RayAccelerations{}, RayAccelerations::None()}) {
    const DepthPyramid left = BladeSeenFrom(-0.5, true), right = BladeSeenFrom(0.5, true);
    EXPECT_TRUE(is_blocked({left, right}, how));
    EXPECT_FALSE(is_blocked({left, BladeSeenFrom(0.5, false)}, how));
    EXPECT_FALSE(is_blocked({BladeSeenFrom(-0.5, false), right}, how));
  }
}

TEST(DepthImageTracerTest, NamesTheFieldThatIsWrong) {
  tbb::task_arena arena(1);
  const auto scene = testing::RandomScene(0);
  RasterDepthSource source(*scene, arena);
  const AreaLight& light = *scene->FindLight("light");
  const auto message = [&](const ReferenceImageSettings& settings) {
    const auto images = DrawReferenceImages(light, *scene, settings, source, arena);
    EXPECT_EQ(images.status().code(), absl::StatusCode::kInvalidArgument);
    return std::string(images.status().message());
  };
  EXPECT_EQ(message({.pixels = 0}), "resolution: found 0, need 1 to 8192");
  EXPECT_EQ(message({.gap = {.metres = NAN}}), "gap_bias: found nan, need a number >= 0");
  EXPECT_EQ(message({.places = {Vec3(0), Vec3(0, NAN, 0)}}), "places[1]: need finite numbers");
}

TEST(DepthImageTracerTest, ImagesHaveALimit) {
  tbb::task_arena arena(1);
  const auto scene = testing::RandomScene(0);
  RasterDepthSource source(*scene, arena);
  const AreaLight& light = *scene->FindLight("light");
  const auto images =
      DrawReferenceImages(light, *scene, {.pixels = 8192, .max_bytes = 1'000'000}, source, arena);
  EXPECT_EQ(images.status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(ErrorFieldPath(images.status()), "resolution");
  EXPECT_THAT(std::string(images.status().message()),
              ::testing::MatchesRegex("resolution: found 8192, with which [0-9]+ images take "
                                      "[0-9]+ bytes, need at most 1000000"));
}

TEST(DepthImageTracerTest, ABiasInMetresIsTaken) {
  const DepthPyramid image = BladeSeenFrom(0, true);
  Batch batch{.from = {Vec3(0, 0, 2.0f), Vec3(0, 0, 1)}, .at_infinity = false};
  batch.x = {0.3f}, batch.y = {0}, batch.z = {0};
  const auto is_blocked = [&](double metres) {
    const DepthImageTracer tracer({image}, {}, {.metres = metres});
    return batch.Trace(tracer, true)[0] != kUnblocked;
  };
  // From behind the blade, or from in front of it once the surface is turned.
  EXPECT_TRUE(is_blocked(0.1));
  batch.from.normal = Vec3(0, 0, -1);
  EXPECT_FALSE(is_blocked(0.1));
}

}  // namespace
}  // namespace penumbra
