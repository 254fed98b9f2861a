// The technique: from a scene and a spec to artifacts.
#include "render/technique/layered_attenuation/layered_attenuation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "render/scene/field_error.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

// A box over a floor of 4 m under a lamp of 1 m; what the floor is, is for the test to say.
SceneDelta BoxUnderLamp() {
  return {.upsert_instances = {{.id = "box",
                                .mesh = MeshOf(UnitBoxGeometry()),
                                .world_from_mesh = Placed(Vec3(0, 1, 0), Vec3(0.4f, 0.2f, 0.3f))}},
          .upsert_lights = {
              {.id = "lamp",
               .shape = RectangleLight{
                   .corner = {-0.5f, 3, -0.5f}, .edge_u = {1, 0, 0}, .edge_v = {0, 0, 1}}}}};
}

Instance Ground(bool casts) {
  return {.id = "ground",
          .mesh = MeshOf(UnitSquareGeometry()),
          .world_from_mesh = Placed(Vec3(0), Vec3(2, 1, 2)),
          .casts = casts};
}

struct Computed {
  absl::StatusOr<Artifact> last;
  std::vector<Artifact> before;
};

Computed Compute(const SceneDelta& delta, const LayeredAttenuationParams& params,
                 bool in_passes = false) {
  const auto scene = Scene::Empty("s")->Apply(delta).value();
  tbb::task_arena arena(2);
  Computed computed;
  ComputeContext context{.arena = arena};
  if (in_passes) {
    context.progress = [&](Artifact pass) { computed.before.push_back(std::move(pass)); };
  }
  computed.last = LayeredAttenuation().Compute(*scene, {params, "lamp"}, context);
  return computed;
}

std::vector<float> FloorShadow(const Artifact& artifact) {
  std::vector<float> shadow;
  for (int k = 0; k < 60 * 60; ++k) {
    const Vec3 point(-1.5f + 0.05f * static_cast<float>(k % 60), 0,
                     -1.5f + 0.05f * static_cast<float>(k / 60));
    shadow.push_back(Visibility(artifact, point, Vec3(0, 1, 0)));
  }
  return shadow;
}

double MeanDifference(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += std::abs(a[i] - b[i]);
  return sum / static_cast<double>(a.size());
}

std::vector<float> ShadowOn(SceneDelta delta, const LayeredAttenuationParams& params) {
  return FloorShadow(*Compute(delta, params).last);
}

// A floor that casts nothing, or is nothing but a receiver, has the same penumbra.
TEST(LayeredAttenuationTest, WhatCastsNothingIsShadowedAllTheSame) {
  for (const bool key_views : {false, true}) {
    const LayeredAttenuationParams params{.key_views = key_views};
    SceneDelta delta = BoxUnderLamp();
    delta.upsert_instances.push_back(Ground(true));
    const auto expected = ShadowOn(delta, params);
    int partly = 0;
    for (const float share : expected) partly += share > 0.05f && share < 0.95f;
    EXPECT_GT(partly, 300);
    delta.upsert_instances.back() = Ground(false);
    EXPECT_LT(MeanDifference(ShadowOn(delta, params), expected), 0.005) << key_views;
    delta.upsert_instances.pop_back();
    delta.upsert_receivers.push_back(FloorReceiver("floor", 4, 64));
    EXPECT_LT(MeanDifference(ShadowOn(delta, params), expected), 0.005) << key_views;
  }
}

// Two layers of glass that do not cast hide nothing from each other.
TEST(LayeredAttenuationTest, WhatCastsNothingHidesNothing) {
  SceneDelta delta = BoxUnderLamp();
  delta.upsert_instances.push_back(Ground(true));
  const auto expected = ShadowOn(delta, {});
  Instance pane = Ground(false);
  pane.id = "pane";
  pane.world_from_mesh = Placed(Vec3(0, 0.5f, 0), Vec3(2, 1, 2));
  delta.upsert_instances.push_back(pane);
  EXPECT_LT(MeanDifference(ShadowOn(delta, {}), expected), 0.01);
}

TEST(LayeredAttenuationTest, PassesCountMoreOfTheSameSamples) {
  SceneDelta delta = BoxUnderLamp();
  delta.upsert_instances.push_back(Ground(true));
  const Computed computed = Compute(delta, {.samples = 64}, true);
  ASSERT_TRUE(computed.last.ok()) << computed.last.status();
  ASSERT_EQ(computed.before.size(), 1u);
  const Artifact& first = computed.before.front();
  EXPECT_FALSE(first.header.is_final);
  EXPECT_TRUE(computed.last->header.is_final);
  EXPECT_EQ(first.header.light_samples.size(), 8u);
  EXPECT_EQ(computed.last->header.light_samples.size(), 64u);
  EXPECT_EQ(std::get<AttenuationLdi>(first.payload).sample_count, 8u);
  for (size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(first.header.light_samples[i].point, computed.last->header.light_samples[i].point);
  }
  EXPECT_LT(MeanDifference(FloorShadow(first), FloorShadow(*computed.last)), 0.05);
  EXPECT_EQ(FloorShadow(*Compute(delta, {.samples = 64}).last), FloorShadow(*computed.last));
}

TEST(LayeredAttenuationTest, TheHeaderSaysWhatDrewTheMaps) {
  SceneDelta delta = BoxUnderLamp();
  const auto drawn_by = [&](DepthMethod source, uint32_t resolution = 64) {
    const Computed computed =
        Compute(delta, {.samples = 4, .resolution = resolution, .source = source});
    return computed.last->header.parameters.at("source");
  };
  EXPECT_EQ(drawn_by(DepthMethod::kRaster), "raster");
  EXPECT_EQ(drawn_by(DepthMethod::kRays), "rays");
  EXPECT_EQ(drawn_by(DepthMethod::kAuto), "raster");
  delta.upsert_instances[0].mesh = MeshOf(BallGeometry(256, 128));
  EXPECT_EQ(drawn_by(DepthMethod::kAuto, 8), "rays");
  delta.upsert_instances.clear();
  EXPECT_EQ(drawn_by(DepthMethod::kAuto), "auto") << "there is nothing to draw";
}

TEST(LayeredAttenuationTest, LimitsAndParametersAreNamed) {
  SceneDelta delta = BoxUnderLamp();
  delta.upsert_instances.push_back(Ground(true));
  const auto fault = [&](const LayeredAttenuationParams& params) {
    const absl::Status status = Compute(delta, params).last.status();
    return ErrorFieldPath(status) + " " + ErrorReason(status);
  };
  EXPECT_EQ(fault({.samples = 0}), "layered_attenuation.samples RANGE");
  EXPECT_EQ(fault({.resolution = 7}), "layered_attenuation.resolution RANGE");
  EXPECT_EQ(fault({.tolerance = 17}), "layered_attenuation.tolerance RANGE");
  EXPECT_EQ(fault({.tolerance = std::nanf("")}), "layered_attenuation.tolerance RANGE");
  EXPECT_EQ(fault({.max_layers = 0}), "layered_attenuation.max_layers RANGE");
  EXPECT_EQ(fault({.max_layers = 129}), "layered_attenuation.max_layers RANGE");
  EXPECT_EQ(ErrorReason(Compute(delta, {.max_layers = 1}).last.status()), "QUOTA_LDI_LAYERS");
  EXPECT_EQ(fault({.source = DepthMethod::kGl}), "layered_attenuation.source NO_GL");
}

TEST(LayeredAttenuationTest, NothingAtAllIsAllLit) {
  SceneDelta delta = BoxUnderLamp();
  delta.upsert_instances.clear();
  const Computed computed = Compute(delta, {});
  ASSERT_TRUE(computed.last.ok()) << computed.last.status();
  EXPECT_EQ(Visibility(*computed.last, Vec3(0), Vec3(0, 1, 0)), 1.0f);
  EXPECT_EQ(Visibility(*computed.last, Vec3(0), Vec3(0, -1, 0)), 0.0f);
}

}  // namespace
}  // namespace penumbra::testing
