// Tracers against every triangle in double precision.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "render/light_view/raster_depth_source.h"
#include "render/math/basis.h"
#include "render/technique/coherent_raytrace/depth_image_tracer.h"
#include "render/technique/coherent_raytrace/reference_images.h"
#include "render/technique/coherent_raytrace/triangle_tracer.h"
#include "tests/support/shapes.h"
#include "tests/unit/coherent_raytrace/exact_verdict.h"
#include "tests/unit/coherent_raytrace/ray_batch.h"

namespace penumbra {
namespace {

using testing::Batch;
using testing::RandomBatch;

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
size_t CompareFans(const ShadowTracer& tracer, const LightSquare& square, bool wants_blockers,
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
  const auto together = testing::TraceFans(tracer, {.fans = fans,
                                                    .at_infinity = square.is_at_infinity(),
                                                    .wants_blockers = wants_blockers,
                                                    .x = x,
                                                    .y = y,
                                                    .z = z});
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
      by_triangles += CompareFans(triangles, square, wants_blockers, dice);
      by_images += CompareFans(images, square, wants_blockers, dice);
    }
  }
  EXPECT_GT(by_triangles, 500u);
  EXPECT_GT(by_images, 500u);
}

// Planes turned any way, near the origin and far from it, do not hide grazing lights from
// themselves; of one two kilometres wide rays begin less than 7 mm over it.
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
      EXPECT_LT(SurfaceOffset(scene->Bounds()), 0.007f + 2e-6f * away) << size << " " << away;
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

}  // namespace
}  // namespace penumbra
