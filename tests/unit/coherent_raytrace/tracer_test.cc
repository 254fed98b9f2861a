// Tracers against every triangle in double precision.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "render/light_view/raster_depth_source.h"
#include "render/math/basis.h"
#include "render/scene/field_error.h"
#include "render/technique/coherent_raytrace/depth_image_tracer.h"
#include "render/technique/coherent_raytrace/light_square.h"
#include "render/technique/coherent_raytrace/reference_images.h"
#include "render/technique/coherent_raytrace/triangle_tracer.h"
#include "tests/support/random_scene.h"
#include "tests/support/shapes.h"
#include "tests/unit/coherent_raytrace/exact_verdict.h"

namespace penumbra {
namespace {

struct Batch {
  std::vector<float> x, y, z;
  SurfacePoint from;
  bool at_infinity;

  std::vector<float> Trace(const ShadowTracer& tracer, bool wants_blockers) const {
    std::vector<float> blocked_at(x.size());
    TraceCounts counts;
    const RayFan fan{from, x.size()};
    tracer.Trace({.fans = {&fan, 1},
                  .at_infinity = at_infinity,
                  .wants_blockers = wants_blockers,
                  .x = x,
                  .y = y,
                  .z = z},
                 blocked_at, counts);
    EXPECT_EQ(counts.rays, x.size());
    return blocked_at;
  }
};

Batch RandomBatch(testing::Dice& dice, const LightSquare& square, size_t count) {
  Batch batch{.from = {dice.InCube(2), dice.Direction()}, .at_infinity = square.is_at_infinity()};
  const LightSquare::Seen seen = square.From(batch.from.position);
  for (size_t i = 0; i < count; ++i) {
    const Vec3 target = seen.TargetAt({dice.Between(0, 1), dice.Between(0, 1)});
    batch.x.push_back(target.x), batch.y.push_back(target.y), batch.z.push_back(target.z);
  }
  return batch;
}

TEST(TriangleTracerTest, IsExactInRandomScenes) {
  CasterBvhs bvhs;
  size_t compared = 0, wrong = 0, blocked_rays = 0;
  for (uint64_t seed = 0; seed < 60; ++seed) {
    testing::Dice dice(seed);
    const auto scene = testing::RandomScene(seed);
    const auto triangles = OccluderTriangles(*scene);
    const LightSquare square(*scene->FindLight("light"));
    const TriangleTracer tracer(bvhs.Flat(*scene), 0.0f);
    for (int i = 0; i < 40; ++i) {
      const Batch batch = RandomBatch(dice, square, 1 + dice.Below(21));
      const auto blocked_at = batch.Trace(tracer, true);
      const auto blocked = batch.Trace(tracer, false);
      for (size_t k = 0; k < blocked_at.size(); ++k) {
        EXPECT_EQ(blocked_at[k] == kUnblocked, blocked[k] == kUnblocked);
        const DVec3 origin(batch.from.position), target(batch.x[k], batch.y[k], batch.z[k]);
        const DVec3 way = square.is_at_infinity() ? target : target - origin;
        const double end = square.is_at_infinity() ? 1e9 : 1 - 0x1p-16;
        const Verdict exact = Exact(triangles, origin, way, end, 1e-4);
        if (exact.is_close) continue;
        ++compared;
        blocked_rays += exact.blocked;
        wrong += exact.blocked != (blocked_at[k] != kUnblocked);
      }
    }
  }
  EXPECT_GT(compared, 10'000u);
  EXPECT_GT(blocked_rays, 1'000u);
  EXPECT_EQ(wrong, 0u) << "of " << compared;
}

// Fans that are cut where a stream is full are the same as each fan alone. Counts the blocked rays.
size_t TraceFans(const ShadowTracer& tracer, const LightSquare& square, bool wants_blockers,
                 testing::Dice& dice) {
  std::vector<RayFan> fans;
  std::vector<float> x, y, z, alone;
  for (const size_t count : {1, 255, 300, 7, 256, 1}) {
    const Batch batch = RandomBatch(dice, square, count);
    x.insert(x.end(), batch.x.begin(), batch.x.end());
    y.insert(y.end(), batch.y.begin(), batch.y.end());
    z.insert(z.end(), batch.z.begin(), batch.z.end());
    fans.push_back({batch.from, x.size()});
    const auto blocked_at = batch.Trace(tracer, wants_blockers);
    alone.insert(alone.end(), blocked_at.begin(), blocked_at.end());
  }
  std::vector<float> together(x.size());
  TraceCounts counts;
  tracer.Trace({.fans = fans,
                .at_infinity = square.is_at_infinity(),
                .wants_blockers = wants_blockers,
                .x = x,
                .y = y,
                .z = z},
               together, counts);
  EXPECT_EQ(counts.rays, x.size());
  size_t blocked = 0;
  for (size_t i = 0; i < x.size(); ++i) {
    EXPECT_EQ(together[i] == kUnblocked, alone[i] == kUnblocked) << i;
    blocked += alone[i] != kUnblocked;
  }
  return blocked;
}

TEST(ShadowTracerTest, FansTogetherAreTracedAsEachAlone) {
  CasterBvhs bvhs;
  tbb::task_arena arena(2);
  size_t by_triangles = 0, by_images = 0;
  for (uint64_t seed = 0; seed < 12; ++seed) {
    testing::Dice dice(seed);
    const auto scene = testing::RandomScene(seed);
    const AreaLight& light = *scene->FindLight("light");
    const LightSquare square(light);
    RasterDepthSource source(*scene, arena);
    const TriangleTracer triangles(bvhs.Flat(*scene), 1e-4f);
    const DepthImageTracer images(
        DrawReferenceImages(light, *scene, {.pixels = 256}, source, arena).value(), {});
    for (const bool wants_blockers : {true, false}) {
      by_triangles += TraceFans(triangles, square, wants_blockers, dice);
      by_images += TraceFans(images, square, wants_blockers, dice);
    }
  }
  EXPECT_GT(by_triangles, 500u);
  EXPECT_GT(by_images, 500u);
}

// Planes turned any way, near the origin and far from it, do not hide grazing lights from
// themselves; a sheet 4 mm over one a kilometre wide still casts a shadow.
TEST(TriangleTracerTest, RaysLeaveTheirSurfaceAndNothingElse) {
  CasterBvhs bvhs;
  testing::Dice dice(8);
  for (const float size : {10.0f, 1000.0f}) {
    for (const float away : {0.0f, 10'000.0f}) {
      const Basis basis = BasisAround(DVec3(dice.Direction()));
      const Vec3 across(basis.s), up(basis.n), along(basis.t);
      const Affine place(size * across, size * up, size * along, away * Vec3(1, 0.3f, -1));
      SceneDelta delta;
      delta.upsert_instances = {{.id = "plane",
                                 .mesh = testing::MeshOf(testing::UnitSquareGeometry()),
                                 .world_from_mesh = place}};
      const auto scene = Scene::Empty("s")->Apply(delta).value();
      const TriangleTracer tracer(bvhs.Flat(*scene), SurfaceOffset(scene->Bounds()));
      for (int i = 0; i < 1000; ++i) {
        const Vec3 at =
            TransformPoint(place, Vec3(dice.Between(-0.4f, 0.4f), 0, dice.Between(-0.4f, 0.4f)));
        Batch batch{.from = {at, up}, .at_infinity = false};
        const Vec3 target = at + size * (across + 0.01f * up);
        batch.x = {target.x}, batch.y = {target.y}, batch.z = {target.z};
        EXPECT_EQ(batch.Trace(tracer, true)[0], kUnblocked) << size << " " << away;
      }
      EXPECT_LT(SurfaceOffset(scene->Bounds()), 0.004f + 2e-6f * away) << size << " " << away;
    }
  }
}

TEST(TriangleTracerTest, BlockersLieOnTriangles) {
  const auto box = testing::MeshOf(testing::UnitBoxGeometry());
  SceneDelta delta;
  delta.upsert_instances = {
      {.id = "box", .mesh = box, .world_from_mesh = testing::Placed(Vec3(0, 2, 0), 0.5f)}};
  const auto scene = Scene::Empty("s")->Apply(delta).value();
  CasterBvhs bvhs;
  const TriangleTracer tracer(bvhs.Flat(*scene), 0.0f);
  testing::Dice dice(3);
  Batch batch{.from = {Vec3(0), Vec3(0, 1, 0)}, .at_infinity = false};
  for (int i = 0; i < 19; ++i) {
    batch.x.push_back(dice.Between(-0.9f, 0.9f)), batch.y.push_back(4);
    batch.z.push_back(dice.Between(-0.9f, 0.9f));
  }
  const auto blocked_at = batch.Trace(tracer, true);
  for (size_t i = 0; i < batch.x.size(); ++i) {
    ASSERT_NE(blocked_at[i], kUnblocked);
    const Vec3 on =
        glm::abs(blocked_at[i] * Vec3(batch.x[i], batch.y[i], batch.z[i]) - Vec3(0, 2, 0));
    EXPECT_NEAR(std::max({on.x, on.y, on.z}), 0.5f, 1e-5f);
  }
}

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
