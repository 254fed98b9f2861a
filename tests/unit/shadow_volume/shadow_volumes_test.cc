// The technique: its parameters, and scenes that are hard or no scenes at all.
#include "render/technique/shadow_volume/shadow_volumes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "render/math/memory_budget.h"
#include "render/scene/field_error.h"
#include "tests/support/shapes.h"

namespace penumbra {
namespace {

using testing::BallGeometry;
using testing::MeshOf;
using testing::Placed;
using testing::UnitBoxGeometry;
using testing::UnitSquareGeometry;

AreaLight PointAt(Vec3 place) { return {.id = "lamp", .shape = PointLight{.position = place}}; }

Instance Box(const std::string& id, Vec3 place, float half = 0.2f) {
  return {.id = id, .mesh = MeshOf(UnitBoxGeometry()), .world_from_mesh = Placed(place, half)};
}

Instance Floor() {
  return {
      .id = "floor", .mesh = MeshOf(UnitSquareGeometry()), .world_from_mesh = Placed(Vec3(0), 2)};
}

std::shared_ptr<const Scene> SceneOf(const SceneDelta& delta) {
  return Scene::Empty("s")->Apply(delta).value();
}

absl::StatusOr<Artifact> Compute(const Scene& scene, const ShadowVolumeParams& params,
                                 TechniqueMemory* memory = nullptr,
                                 std::vector<Artifact>* passes = nullptr) {
  tbb::task_arena arena(2);
  ComputeContext context{.arena = arena, .memory = memory};
  if (passes) context.progress = [&](Artifact pass) { passes->push_back(std::move(pass)); };
  return ShadowVolumes().Compute(scene, {params, "lamp"}, context);
}

const ShadowVolumeMesh& MeshIn(const Artifact& artifact) {
  return std::get<ShadowVolumeMesh>(artifact.payload);
}

float OnFloor(const Artifact& artifact, float x, float z) {
  return Visibility(artifact, Vec3(x, 0, z), Vec3(0, 1, 0));
}

// A box 0.4 m wide, its top at 1.2 m, under a lamp at 3 m: its shadow reaches to 0.33 m.
TEST(ShadowVolumesTest, EverySurfaceAndVolumeHasTheShadowOfABox) {
  const auto scene = SceneOf({.upsert_instances = {Floor(), Box("box", {0, 1, 0})},
                              .upsert_lights = {PointAt({0, 3, 0})}});
  for (const auto surface : {VolumeSurface::kTemplate, VolumeSurface::kFixed, VolumeSurface::kAll,
                             VolumeSurface::kLines}) {
    for (const auto of : {VolumesOf::kScene, VolumesOf::kInstances, VolumesOf::kEdges}) {
      const auto artifact = Compute(*scene, {.surface = surface, .volumes_of = of});
      ASSERT_TRUE(artifact.ok()) << artifact.status();
      EXPECT_EQ(MeshIn(*artifact).volumes.size(), of == VolumesOf::kScene ? 1u : 2u);
      const std::string which = std::string(NameOf(surface)) + " of " + std::string(NameOf(of));
      for (const float t : {0.0f, 0.15f, -0.3f}) {
        EXPECT_EQ(OnFloor(*artifact, t, 0.3f), 0.0f) << which << " " << t;
      }
      for (const float t : {0.36f, -0.5f, 1.5f}) {
        EXPECT_EQ(OnFloor(*artifact, t, 0.1f), 1.0f) << which << " " << t;
      }
      EXPECT_EQ(artifact->header.parameters.at("surface"), std::string(NameOf(surface)));
      EXPECT_FALSE(artifact->header.parameters.contains("warning"));
    }
  }
}

TEST(ShadowVolumesTest, ParametersAreChecked) {
  const auto scene = SceneOf({.upsert_lights = {PointAt({0, 3, 0})}});
  const std::pair<ShadowVolumeParams, const char*> wrong[] = {
      {{.resolution = 1}, "shadow_volume.resolution"},
      {{.resolution = 8193}, "shadow_volume.resolution"},
      {{.bias = -1}, "shadow_volume.bias"},
      {{.bias = NAN}, "shadow_volume.bias"},
      {{.low_threshold = -1}, "shadow_volume.low_threshold"},
      {{.low_threshold = NAN}, "shadow_volume.low_threshold"},
      {{.high_threshold = INFINITY}, "shadow_volume.low_threshold"},
      {{.low_threshold = 1, .high_threshold = 2e6f}, "shadow_volume.high_threshold"},
      {{.low_threshold = 5, .high_threshold = 1}, "shadow_volume.low_threshold"},
  };
  for (const auto& [params, field] : wrong) {
    const auto status = Compute(*scene, params).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << field;
    EXPECT_EQ(ErrorFieldPath(status), field) << status;
  }
  const auto order = Compute(*scene, {.low_threshold = 5, .high_threshold = 1}).status();
  EXPECT_NE(order.message().find("found 5 above high_threshold 1, need at most that"),
            std::string::npos)
      << order;
  tbb::task_arena arena(1);
  ComputeContext context{.arena = arena};
  const auto unknown = ShadowVolumes().Compute(*scene, {ShadowVolumeParams{}, "sun"}, context);
  EXPECT_EQ(unknown.status().code(), absl::StatusCode::kNotFound);
  const auto without_gl =
      Compute(*SceneOf({.upsert_instances = {Floor()}, .upsert_lights = {PointAt({0, 3, 0})}}),
              {.source = DepthMethod::kGl})
          .status();
  EXPECT_EQ(without_gl.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(ErrorFieldPath(without_gl), "shadow_volume.source") << without_gl;
}

TEST(ShadowVolumesTest, NothingToSeeIsNoVolume) {
  for (const VolumesOf of : {VolumesOf::kScene, VolumesOf::kInstances, VolumesOf::kEdges}) {
    const auto empty = SceneOf({.upsert_lights = {PointAt({0, 3, 0})}});
    const auto artifact = Compute(*empty, {.volumes_of = of});
    ASSERT_TRUE(artifact.ok()) << artifact.status();
    EXPECT_TRUE(MeshIn(*artifact).volumes.empty());
    EXPECT_EQ(OnFloor(*artifact, 0, 0), 1.0f);
  }
  // All of it behind a light that shines one way.
  AreaLight up = {
      .id = "lamp",
      .shape = DiskLight{
          .center = Vec3(0, 3, 0), .normal = Vec3(0, 1, 0), .radius = 1, .two_sided = false}};
  const auto behind =
      SceneOf({.upsert_instances = {Floor(), Box("box", {0, 1, 0})}, .upsert_lights = {up}});
  const auto artifact = Compute(*behind, {});
  ASSERT_TRUE(artifact.ok()) << artifact.status();
  EXPECT_TRUE(MeshIn(*artifact).volumes.empty());
  EXPECT_EQ(OnFloor(*artifact, 0, 0), 0.0f);
}

// All around is in the shadow of what the lamp is in.
TEST(ShadowVolumesTest, ALightInsideAnObject) {
  const auto scene = SceneOf({.upsert_instances = {Floor(), Box("shade", {0, 1, 0})},
                              .upsert_lights = {PointAt({0.05f, 1.02f, 0})}});
  for (const VolumesOf of : {VolumesOf::kScene, VolumesOf::kInstances, VolumesOf::kEdges}) {
    const auto artifact = Compute(*scene, {.resolution = 128, .volumes_of = of});
    ASSERT_TRUE(artifact.ok()) << artifact.status();
    for (const float x : {-1.7f, 0.0f, 0.4f, 1.9f}) EXPECT_EQ(OnFloor(*artifact, x, 0.2f), 0.0f);
    EXPECT_EQ(Visibility(*artifact, Vec3(0.1f, 1.02f, 0), Vec3(-1, 0, 0)), 1.0f);
  }
}

// Thresholds that take everything for an edge make many triangles and say so, and the shadow is as
// right as ever.
TEST(ShadowVolumesTest, ThresholdsThatSelectEverythingAreWarnedOf) {
  const auto scene = SceneOf({.upsert_instances = {Floor(), Box("box", {0, 1, 0})},
                              .upsert_lights = {PointAt({0.4f, 3, 0.2f})}});
  const auto usual = Compute(*scene, {}).value();
  const auto all = Compute(*scene, {.low_threshold = 1e-6f, .high_threshold = 1e-6f}).value();
  EXPECT_GT(MeshIn(all).edge_fraction, 0.5f);
  EXPECT_NE(all.header.parameters.at("warning").find("% of all places"), std::string::npos);
  EXPECT_GT(MeshIn(all).triangle_count(), 4 * MeshIn(usual).triangle_count());
  std::mt19937 random(5);
  std::uniform_real_distribution<float> place(-1.9f, 1.9f);
  for (int i = 0; i < 500; ++i) {
    const float x = place(random), z = place(random);
    EXPECT_EQ(OnFloor(all, x, z), OnFloor(usual, x, z)) << x << " " << z;
  }
}

// By itself, and with all samples ready to be looked up in, a point is the same.
TEST(ShadowVolumesTest, PointsAreLookedUpInTwoWays) {
  const Vec3 places[] = {{0.3f, 3, 0.2f}, {0.1f, 0.4f, 0.2f}};  // one view, and six
  std::mt19937 random(6);
  std::uniform_real_distribution<float> coordinate(-1.9f, 1.9f);
  for (const Vec3 place : places) {
    const auto scene = SceneOf(
        {.upsert_instances = {Floor(), Box("box", {0, 1, 0})}, .upsert_lights = {PointAt(place)}});
    for (const VolumesOf of : {VolumesOf::kScene, VolumesOf::kInstances, VolumesOf::kEdges}) {
      const auto artifact = Compute(*scene, {.resolution = 64, .volumes_of = of}).value();
      const VolumeLookup lookup(MeshIn(artifact));
      int dark = 0;
      for (int i = 0; i < 2000; ++i) {
        const Vec3 point(coordinate(random), 0.5f * coordinate(random), coordinate(random));
        const float seen = Visibility(artifact, point, Vec3(0, 1, 0));
        EXPECT_EQ(seen, lookup.Visibility(point, Vec3(0, 1, 0)));
        dark += seen == 0;
      }
      EXPECT_GT(dark, 100);
      EXPECT_LT(dark, 1900);
    }
  }
}

// One threshold decides on the other.
TEST(ShadowVolumesTest, EitherThresholdMayBeGiven) {
  const auto scene = SceneOf({.upsert_instances = {Floor(), Box("box", {0, 1, 0})},
                              .upsert_lights = {PointAt({0.4f, 3, 0.2f})}});
  const auto low = Compute(*scene, {.low_threshold = 3}).value();
  const auto high = Compute(*scene, {.high_threshold = 12}).value();
  EXPECT_EQ(low.header.parameters.at("high_threshold"), "12");
  const auto tenth = Compute(*scene, {.high_threshold = 0.1f}).value().header.parameters;
  EXPECT_EQ(tenth.at("high_threshold"), "0.1");
  EXPECT_EQ(high.header.parameters.at("low_threshold"), "3");
  EXPECT_EQ(MeshIn(low).volumes[0]->indices, MeshIn(high).volumes[0]->indices);
}

// Two floors that meet without a step: told apart by whose they are.
TEST(ShadowVolumesTest, ObjectIdsFindEdgesWithoutASteps) {
  Instance right = Floor();
  right.id = "right";
  right.world_from_mesh = Placed(Vec3(4, 0, 0), 2);
  const auto scene =
      SceneOf({.upsert_instances = {Floor(), right}, .upsert_lights = {PointAt({2, 3, 0})}});
  const auto by_depth = Compute(*scene, {.resolution = 64}).value();
  const auto by_id = Compute(*scene, {.resolution = 64, .object_ids = true}).value();
  EXPECT_GT(MeshIn(by_id).edge_fraction, MeshIn(by_depth).edge_fraction);
  EXPECT_GT(MeshIn(by_id).triangle_count(), MeshIn(by_depth).triangle_count());
  EXPECT_EQ(OnFloor(by_id, 1.99f, 0.3f), 1.0f);
}

TEST(ShadowVolumesTest, WhatDidNotMoveIsKept) {
  SceneDelta delta{.upsert_instances = {Floor(), Box("a", {-1, 0.5f, 0}), Box("b", {1, 0.5f, 0})},
                   .upsert_lights = {PointAt({0, 3, 0})}};
  const auto scene = SceneOf(delta);
  MemoryBudget budget(size_t{64} << 20);
  TechniqueMemory memory{.budget = budget};
  const ShadowVolumeParams params{.volumes_of = VolumesOf::kInstances};
  const auto before = Compute(*scene, params, &memory).value();
  SceneDelta move;
  move.upsert_instances = {Box("b", {1, 0.6f, 0.1f})};
  const auto after = Compute(*scene->Apply(move).value(), params, &memory).value();
  ASSERT_EQ(MeshIn(after).volumes.size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    const auto &one = MeshIn(before).volumes[i], &other = MeshIn(after).volumes[i];
    EXPECT_EQ(one == other, one->instance_id != "b") << one->instance_id;
    EXPECT_EQ(one->content == other->content, one == other);
  }
}

// The sum counts, however little of it is new.
TEST(ShadowVolumesTest, TheQuotaIsOfAllVolumes) {
  SceneDelta delta{.upsert_lights = {PointAt({0, 9, 0})}};
  const auto ball = [](const std::string& id) {
    return Instance{.id = id,
                    .mesh = MeshOf(BallGeometry(8, 4)),
                    .world_from_mesh = Placed(Vec3(0, 0.1f, 0), 2)};
  };
  delta.upsert_instances = {ball("b")};
  const auto one = SceneOf(delta);
  MemoryBudget budget(size_t{64} << 20);
  TechniqueMemory memory{.budget = budget};
  const ShadowVolumeParams params{.resolution = 6000, .volumes_of = VolumesOf::kInstances};
  ASSERT_TRUE(Compute(*one, params, &memory).ok());
  SceneDelta more;
  more.upsert_instances = {ball("a"), ball("c")};
  const auto kept = Compute(*one->Apply(more).value(), params, &memory).status();
  const auto fresh = Compute(*one->Apply(more).value(), params).status();
  EXPECT_EQ(kept.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(kept, fresh);
}

TEST(ShadowVolumesTest, TooManyTrianglesAreRefused) {
  const auto scene =
      SceneOf({.upsert_instances = {Floor()}, .upsert_lights = {PointAt({0.4f, 3, 0.2f})}});
  const auto status =
      Compute(*scene, {.resolution = 4096, .surface = VolumeSurface::kAll}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(ErrorFieldPath(status), "shadow_volume.resolution");
  EXPECT_EQ(ErrorReason(status), "QUOTA_VOLUME_TRIANGLES");
}

TEST(ShadowVolumesTest, LargeMapsComeCoarseFirst) {
  const auto scene = SceneOf({.upsert_instances = {Floor(), Box("box", {0, 1, 0})},
                              .upsert_lights = {PointAt({0, 3, 0})}});
  std::vector<Artifact> passes;
  const auto artifact = Compute(*scene, {.resolution = 1024}, nullptr, &passes).value();
  ASSERT_EQ(passes.size(), 1u);
  EXPECT_EQ(passes[0].header.parameters.at("resolution"), "256");
  EXPECT_FALSE(passes[0].header.is_final);
  EXPECT_TRUE(artifact.header.is_final);
  EXPECT_EQ(artifact.header.pass, 1u);
  // Once all is there, an edit sends what it changed, and nothing coarse between.
  MemoryBudget budget(size_t{64} << 20);
  TechniqueMemory memory{.budget = budget};
  passes.clear();
  ASSERT_TRUE(Compute(*scene, {.resolution = 1024}, &memory, &passes).ok());
  ASSERT_TRUE(Compute(*scene, {.resolution = 1024}, &memory, &passes).ok());
  EXPECT_EQ(passes.size(), 1u);
}

// A ball each, so large that every map of one is as large as that of all.
TEST(ShadowVolumesTest, TooManyTexelsAreRefused) {
  SceneDelta delta{.upsert_lights = {PointAt({0, 9, 0})}};
  for (int i = 0; i < 8; ++i) {
    delta.upsert_instances.push_back({.id = "ball" + std::to_string(i),
                                      .mesh = MeshOf(BallGeometry(8, 4)),
                                      .world_from_mesh = Placed(Vec3(0, 0.1f, 0), 2)});
  }
  const auto status =
      Compute(*SceneOf(delta), {.resolution = 8192, .volumes_of = VolumesOf::kInstances}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(ErrorFieldPath(status), "shadow_volume.resolution") << status;
}

}  // namespace
}  // namespace penumbra
