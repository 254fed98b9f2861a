// What is proven lit, every ray confirms.
#include "render/technique/coherent_raytrace/light_proof.h"

#include <gtest/gtest.h>

#include <vector>

#include "render/technique/coherent_raytrace/point_samples.h"
#include "render/technique/coherent_raytrace/triangle_tracer.h"
#include "tests/support/random_scene.h"
#include "tests/support/shapes.h"
#include "tests/unit/coherent_raytrace/exact_verdict.h"
#include "tests/unit/coherent_raytrace/ray_batch.h"

namespace penumbra {
namespace {

constexpr uint32_t kSide = 8;

// How many of the cells that are proven lit have a blocked ray; counts the proven ones. A tracer
// may block rays within rounding of an edge: of these nothing is held against the proof.
size_t WrongCells(const LightProof& proof, const ShadowTracer& tracer,
                  const std::vector<OccluderTriangle>& triangles, const LightSquare& square,
                  const SurfacePoint& point, uint64_t index, size_t& proven) {
  const CellMask lit = proof.LitFrom(point, kSide);
  SampleBatch samples;
  samples.Add(lit, {kSide, 1}, SampleSeed(7, index));
  proven += samples.count;
  const LightSquare::Seen seen = square.From(point.position);
  const bool at_infinity = square.is_at_infinity();
  const std::vector<float> padded(samples.count + kSamplerLanes);
  testing::Batch batch{
      .x = padded, .y = padded, .z = padded, .from = point, .at_infinity = at_infinity};
  seen.TargetsAt(samples.count, samples.u.data(), samples.v.data(), batch.x.data(), batch.y.data(),
                 batch.z.data());
  for (auto* axis : {&batch.x, &batch.y, &batch.z}) axis->resize(samples.count);
  const std::vector<float> blocked_at = batch.Trace(tracer, false);
  size_t wrong = 0;
  for (size_t i = 0; i < samples.count; ++i) {
    if (blocked_at[i] == kUnblocked) continue;
    const DVec3 origin(point.position), to(batch.x[i], batch.y[i], batch.z[i]);
    const DVec3 way = at_infinity ? to : to - origin;
    wrong += !Exact(triangles, origin, way, at_infinity ? 1e9 : 1.0, 1e-6).is_close;
  }
  return wrong;
}

// Points anywhere, most of them on no surface: the proof must hold for any.
TEST(LightProofTest, EveryProvenCellIsSeenInRandomScenes) {
  CasterBvhs bvhs;
  tbb::task_arena arena(2);
  size_t proven = 0, wrong = 0;
  for (uint64_t seed = 0; seed < 1000; ++seed) {
    testing::Dice dice(seed);
    const auto scene = testing::RandomScene(seed);
    const AreaLight& light = *scene->FindLight("light");
    const LightProof proof(light, *scene,
                           {.pixels = 200, .bias = 0.0, .has_quarters = seed % 2 == 0}, arena);
    const LightSquare square(light);
    const auto triangles = OccluderTriangles(*scene);
    const TriangleTracer tracer(bvhs.Flat(*scene), SurfaceOffset(scene->Bounds()));
    for (uint64_t i = 0; i < 60; ++i) {
      const SurfacePoint point{dice.InCube(3), dice.Direction()};
      wrong += WrongCells(proof, tracer, triangles, square, point, i, proven);
    }
  }
  EXPECT_GT(proven, 41'667u);
  EXPECT_EQ(wrong, 0u) << "of " << proven;
}

// Wires thinner than a hundredth of a pixel between floor and lamp.
TEST(LightProofTest, NothingIsTooThinForIt) {
  testing::Dice dice(5);
  MeshGeometry wires;
  for (int i = 0; i < 40; ++i) {
    const Vec3 a = dice.InCube(2) * Vec3(1, 0.2f, 1), b = a + 0.5f * dice.Direction();
    const auto k = static_cast<uint32_t>(wires.positions.size());
    wires.positions.insert(wires.positions.end(), {a, b, b + Vec3(1e-5f, 0, 1e-5f)});
    wires.indices.insert(wires.indices.end(), {k, k + 1, k + 2});
  }
  SceneDelta delta;
  delta.upsert_instances = {{.id = "wires",
                             .mesh = testing::MeshOf(wires),
                             .world_from_mesh = testing::Placed(Vec3(0, 1, 0))},
                            {.id = "floor",
                             .mesh = testing::MeshOf(testing::UnitSquareGeometry()),
                             .world_from_mesh = testing::Placed(Vec3(0), 3.0f)}};
  delta.upsert_lights = {{.id = "lamp", .shape = RectangleLight{.corner = {-0.5f, 4, -0.5f}}}};
  const auto scene = Scene::Empty("s")->Apply(delta).value();
  tbb::task_arena arena(2);
  const LightProof proof(*scene->FindLight("lamp"), *scene, {.pixels = 256, .has_quarters = true},
                         arena);
  size_t lit = 0;
  for (int i = 0; i < 4000; ++i) {
    const Vec3 p(dice.Between(-2.5f, 2.5f), 0, dice.Between(-2.5f, 2.5f));
    if (proof.LitFrom({p, Vec3(0, 1, 0)}, kSide) != CellMask::All(kSide)) continue;
    ++lit;
    // No wire's end, which is a point of it, lies in the hull of the point and the lamp.
    for (const Vec3& end : wires.positions) {
      const Vec3 q = end + Vec3(0, 1, 0);
      const Vec3 on_lamp = p + 4.0f / q.y * (q - p);
      if (q.y <= 0.01f || std::abs(on_lamp.x) >= 0.5f || std::abs(on_lamp.z) >= 0.5f) continue;
      ADD_FAILURE() << "at " << p.x << ", " << p.z << " before " << on_lamp.x << ", " << on_lamp.z;
    }
  }
  EXPECT_GT(lit, 200u);
}

TEST(LightProofTest, ProvesAnOpenFloorAndNothingBelowTheHorizon) {
  SceneDelta delta;
  delta.upsert_instances = {{.id = "floor",
                             .mesh = testing::MeshOf(testing::UnitSquareGeometry()),
                             .world_from_mesh = testing::Placed(Vec3(0), 2.0f)}};
  delta.upsert_lights = {
      {.id = "r", .shape = RectangleLight{.corner = {-0.5f, 3, -0.5f}}},
      {.id = "d", .shape = DiskLight{.center = {0, 3, 0}}},
      {.id = "s", .shape = DistantLight{.to_light = {0.3f, 1, 0.2f}, .angular_diameter = 0.3f}}};
  const auto scene = Scene::Empty("s")->Apply(delta).value();
  tbb::task_arena arena(2);
  testing::Dice dice(8);
  for (const auto& [id, light] : scene->lights()) {
    const LightProof proof(*light, *scene, {.pixels = 256}, arena);
    for (int i = 0; i < 200; ++i) {
      const Vec3 p(dice.Between(-1.9f, 1.9f), 0, dice.Between(-1.9f, 1.9f));
      EXPECT_EQ(proof.LitFrom({p, Vec3(0, 1, 0)}, kSide), CellMask::All(kSide)) << id;
      EXPECT_TRUE(proof.LitFrom({p, Vec3(0, -1, 0)}, kSide).empty()) << id;
    }
  }
}

}  // namespace
}  // namespace penumbra
