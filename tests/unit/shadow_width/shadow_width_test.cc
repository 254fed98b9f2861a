// The technique: from a scene and a spec to maps.
#include "render/technique/shadow_width/shadow_width.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <tuple>
#include <utility>
#include <vector>

#include "render/scene/field_error.h"
#include "tests/unit/shadow_width/small_scenes.h"

namespace penumbra::testing {
namespace {

using ::testing::HasSubstr;

const ShadowWidthMap& MapOf(const Artifact& artifact) {
  return std::get<ShadowWidthMap>(artifact.payload);
}

float Deepest(const Artifact& artifact) {
  float deepest = 0;
  for (const ShadowWidthFace& face : MapOf(artifact).faces) {
    for (const float width : face.near.widths) deepest = std::max(deepest, width);
  }
  return deepest;
}

TEST(ShadowWidthTest, AFloorThatCastsIsLit) {
  for (const uint32_t layers : {1u, 2u}) {
    const auto artifact = Compute({.upsert_instances = {Ground()}, .upsert_lights = {Lamp(0.5f)}},
                                  {.layers = layers});
    ASSERT_TRUE(artifact.ok()) << artifact.status();
    EXPECT_EQ(Deepest(*artifact), 0.0f);
    for (const float x : {-1.9f, -0.3f, 0.0f, 1.9f}) EXPECT_EQ(OnFloor(*artifact, x, 0.4f), 1.0f);
  }
}

// The box is 0.4 m wide, 1 m over the floor under a lamp at 3 m: its image is 0.2 wide.
TEST(ShadowWidthTest, WidthsAreDistancesToTheOutline) {
  const auto artifact =
      Compute({.upsert_instances = {Ground(), Box("box", {0, 1, 0}, Vec3(0.2f, 0.01f, 0.2f))},
               .upsert_lights = {Lamp(0.5f)}},
              {.resolution = 1024});
  ASSERT_TRUE(artifact.ok()) << artifact.status();
  const double pixel = 1 / MapOf(*artifact).faces[0].view.pixels_per_slope().x;
  EXPECT_NEAR(Deepest(*artifact), 0.2 / 1.99, 3 * pixel);
  EXPECT_LT(OnFloor(*artifact, 0, 0), 0.5f);
  EXPECT_EQ(OnFloor(*artifact, 0.5f, 0), 1.0f);
}

// Blockers, receivers, and instances that are both.
TEST(ShadowWidthTest, FlagsSayWhatBlocksAndWhatReceives) {
  for (const bool floor_casts : {false, true}) {
    for (const bool box_receives : {false, true}) {
      Instance ground = Ground(), box = Box("box", {0, 1, 0}, Vec3(0.4f, 0.1f, 0.4f));
      ground.casts = floor_casts;
      box.receives = box_receives;
      SceneDelta delta{.upsert_instances = {ground, box}, .upsert_lights = {Lamp(0.1f)}};
      EXPECT_LT(OnFloor(*Compute(delta, {}), 0.2f, 0.2f), 0.01f);
      EXPECT_EQ(OnFloor(*Compute(delta, {}), 1.2f, 0.2f), 1.0f);
      delta.upsert_instances[1].casts = false;
      EXPECT_EQ(OnFloor(*Compute(delta, {}), 0.2f, 0.2f), 1.0f);
    }
  }
}

// Half of the box is over nothing: its shadow on the floor does not pale towards the floor's edge.
TEST(ShadowWidthTest, AShadowGoesOnWhereTheFloorEnds) {
  const SceneDelta delta{
      .upsert_instances = {Ground(), Box("box", {1.33f, 1, 0}, Vec3(0.6f, 0.1f, 0.6f))},
      .upsert_lights = {Lamp(0.2f)}};
  const auto artifact = Compute(delta, {});
  EXPECT_LT(OnFloor(*artifact, 1.98f, 0), 0.02f);
  EXPECT_LT(OnFloor(*artifact, 1.6f, 0), 0.02f);
}

// A cup's shadow on a table that shades the floor has the cup's outline, not the table's.
TEST(ShadowWidthTest, ATableAboveAFloorHasShadowsOfItsOwn) {
  const SceneDelta delta{
      .upsert_instances = {Ground(), Box("table", {0, 0.7f, 0}, Vec3(0.8f, 0.02f, 0.8f)),
                           Box("cup", {0, 1.3f, 0}, Vec3(0.1f, 0.05f, 0.1f))},
      .upsert_lights = {Lamp(1.0f)}};
  const auto alone =
      Compute({.upsert_instances = {delta.upsert_instances[1], delta.upsert_instances[2]},
               .upsert_lights = {Lamp(1.0f)}},
              {});
  const auto two = Compute(delta, {.layers = 2}),
             one = Compute(delta, {.layers = 1, .blocker_depth = BlockerDepth::kNearest});
  const float on_table = 0.72f;
  for (const float x : {0.0f, 0.05f, 0.1f, 0.2f}) {
    EXPECT_NEAR(OnFloor(*two, x, 0, on_table), OnFloor(*alone, x, 0, on_table), 0.05f) << x;
  }
  // The paper's widths are those of the joined outline.
  EXPECT_LT(OnFloor(*one, 0.05f, 0, on_table), OnFloor(*two, 0.05f, 0, on_table) - 0.2f);
  // Below the table it is dark, under the cup as well.
  EXPECT_LT(OnFloor(*two, 0, 0), 0.1f);
  EXPECT_LT(OnFloor(*two, 0.3f, 0), 0.2f);
  EXPECT_EQ(OnFloor(*two, 1.8f, 0), 1.0f);
}

TEST(ShadowWidthTest, WithTheNearestDepthShadowsAreSofter) {
  const SceneDelta delta{
      .upsert_instances = {Ground(), Box("box", {0, 0.6f, 0}, Vec3(0.4f, 0.5f, 0.4f))},
      .upsert_lights = {Lamp(1.0f)}};
  const auto nearest = Compute(delta, {.blocker_depth = BlockerDepth::kNearest});
  const auto farthest = Compute(delta, {.blocker_depth = BlockerDepth::kFarthest});
  EXPECT_LT(OnFloor(*farthest, 0.5f, 0), OnFloor(*nearest, 0.5f, 0) - 0.1f);
}

TEST(ShadowWidthTest, AConstantNarrowsPenumbras) {
  const SceneDelta delta{
      .upsert_instances = {Ground(), Box("box", {0, 1, 0}, Vec3(0.4f, 0.1f, 0.4f))},
      .upsert_lights = {Lamp(1.0f)}};
  float before = 1;
  for (const float c_scale : {0.5f, 1.0f, 2.0f, 8.0f}) {
    const float share = OnFloor(*Compute(delta, {.c_scale = c_scale}), 0.5f, 0);
    EXPECT_LT(share, before) << c_scale;
    before = share;
  }
  EXPECT_GT(OnFloor(*Compute(delta, {.c_scale = 1, .c_bias = 0.2f}), 0.5f, 0),
            OnFloor(*Compute(delta, {.c_scale = 1}), 0.5f, 0));
}

// A lamp in the middle of a room looks six ways; a shadow across a border has no seam.
TEST(ShadowWidthTest, FacesJoin) {
  std::vector<Instance> room;
  for (const Vec3 way : {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 1, 0), Vec3(0, -1, 0),
                         Vec3(0, 0, 1), Vec3(0, 0, -1)}) {
    room.push_back(
        Box("wall" + std::to_string(room.size()), 2.05f * way, Vec3(2.1f) - 2.05f * glm::abs(way)));
  }
  // Across the edge between the floor's face and that towards +x.
  room.push_back(Box("bar", {0.6f, -0.6f, 0}, Vec3(0.02f, 0.02f, 0.3f)));
  const auto artifact =
      Compute({.upsert_instances = room,
               .upsert_lights = {{.id = "lamp", .shape = SphereLight{.radius = 0.15f}}}},
              {.resolution = 256});
  ASSERT_TRUE(artifact.ok()) << artifact.status();
  EXPECT_EQ(MapOf(*artifact).faces.size(), 6u);
  // Up the wall and along the floor from their corner, where the bar's shadow lies.
  for (float z = -1; z <= 1; z += 0.05f) {
    const float floor = Visibility(*artifact, Vec3(1.99f, -2, z), Vec3(0, 1, 0));
    const float wall = Visibility(*artifact, Vec3(2, -1.99f, z), Vec3(-1, 0, 0));
    EXPECT_NEAR(floor, wall, 0.1f) << z;
  }
  EXPECT_LT(Visibility(*artifact, Vec3(1.99f, -2, 0), Vec3(0, 1, 0)), 0.9f);
}

TEST(ShadowWidthTest, LargeMapsComeCoarseFirst) {
  const SceneDelta delta{.upsert_instances = {Ground(), Box("box", {0, 1, 0}, Vec3(0.4f))},
                         .upsert_lights = {Lamp(0.5f)}};
  std::vector<Artifact> passes;
  const auto last = Compute(delta, {.resolution = 1024}, &passes);
  ASSERT_TRUE(last.ok());
  ASSERT_EQ(passes.size(), 1u);
  EXPECT_FALSE(passes[0].header.is_final);
  EXPECT_EQ(passes[0].header.pass, 0u);
  EXPECT_EQ(passes[0].header.parameters.at("resolution"), "256");
  EXPECT_TRUE(last->header.is_final);
  EXPECT_EQ(last->header.pass, 1u);
  EXPECT_NEAR(OnFloor(passes[0], 0.3f, 0.1f), OnFloor(*last, 0.3f, 0.1f), 0.1f);
  passes.clear();
  EXPECT_TRUE(Compute(delta, {.resolution = 512}, &passes).ok());
  EXPECT_TRUE(passes.empty());
}

TEST(ShadowWidthTest, OddScenesAreAnswered) {
  const Instance box = Box("box", {0, 1, 0}, Vec3(0.4f));
  // Nothing at all, and nothing before the light.
  for (const SceneDelta& delta :
       {SceneDelta{.upsert_lights = {Lamp(1)}},
        SceneDelta{.upsert_instances = {Box("above", {0, 9, 0}, Vec3(1))},
        .upsert_lights = {{.id = "lamp", .shape = SpotLight{.position = {0, 3, 0}}}}}}) {
    const auto artifact = Compute(delta, {});
    ASSERT_TRUE(artifact.ok()) << artifact.status();
    EXPECT_TRUE(MapOf(*artifact).faces.empty());
    EXPECT_EQ(OnFloor(*artifact, 0, 0), 1.0f);
  }
  // A light inside an object.
  const auto inside =
      Compute({.upsert_instances = {Ground(), Box("box", {0, 1, 0}, Vec3(0.5f))},
               .upsert_lights = {{.id = "lamp", .shape = PointLight{.position = {0, 1, 0}}}}},
              {});
  ASSERT_TRUE(inside.ok()) << inside.status();
  EXPECT_EQ(OnFloor(*inside, 1.5f, 0), 0.0f);
  // Maps of one texel.
  const auto tiny =
      Compute({.upsert_instances = {Ground(), box}, .upsert_lights = {Lamp(1)}}, {.resolution = 1});
  ASSERT_TRUE(tiny.ok()) << tiny.status();
  const float share = OnFloor(*tiny, 0.2f, 0.1f);
  EXPECT_TRUE(share >= 0 && share <= 1);
}

// Six faces of 8192 texels a side are more than a client takes.
TEST(ShadowWidthTest, TooManyTexelsAreRefused) {
  const auto status =
      Compute({.upsert_instances = {Box("room", Vec3(0), Vec3(2))},
               .upsert_lights = {{.id = "lamp", .shape = SphereLight{.radius = 0.1f}}}},
              {.resolution = 8192})
          .status();
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(ErrorReason(status), "QUOTA_WIDTH_TEXELS");
  EXPECT_EQ(ErrorFieldPath(status), "shadow_width.resolution");
}

TEST(ShadowWidthTest, ParametersOutOfRangeAreNamed) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const SceneDelta delta{.upsert_lights = {Lamp(1)}};
  using Bad = std::tuple<ShadowWidthParams, const char*, const char*>;
  for (const auto& [params, field, text] : {
           Bad{{.resolution = 0}, "shadow_width.resolution", "found 0, need 1 to 8192"},
           Bad{{.resolution = 8193}, "shadow_width.resolution", "found 8193"},
           Bad{{.layers = 0}, "shadow_width.layers", "need 1 or 2"},
           Bad{{.layers = 3}, "shadow_width.layers", "found 3"},
           Bad{{.c_scale = -1}, "shadow_width.c_scale", "found -1"},
           Bad{{.c_scale = nan}, "shadow_width.c_scale", "found nan"},
           Bad{{.c_bias = 1.5f}, "shadow_width.c_bias", "need 0 to 1"},
       }) {
    const auto status = Compute(delta, params).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_EQ(ErrorFieldPath(status), field);
    EXPECT_THAT(std::string(status.message()), HasSubstr(text));
  }
}

TEST(ShadowWidthTest, WithoutGlItSaysSo) {
  const SceneDelta delta{.upsert_instances = {Ground()}, .upsert_lights = {Lamp(1)}};
  const auto status = Compute(delta, {.source = DepthMethod::kGl}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(ErrorReason(status), "NO_GL");
  EXPECT_EQ(ErrorFieldPath(status), "shadow_width.source");
  const auto distance = Compute(delta, {.distance = DistanceMethod::kGlSix}).status();
  EXPECT_EQ(distance.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(ErrorFieldPath(distance), "shadow_width.distance");
}

TEST(ShadowWidthTest, ObeysAStop) {
  const auto scene = Scene::Empty("s")
                         ->Apply({.upsert_instances = {Ground()}, .upsert_lights = {Lamp(1)}})
                         .value();
  tbb::task_arena arena(2);
  std::stop_source stop;
  stop.request_stop();
  const auto status = ShadowWidth()
                          .Compute(*scene, {ShadowWidthParams{}, "lamp"},
                                   {.arena = arena, .stop = stop.get_token()})
                          .status();
  EXPECT_EQ(status.code(), absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace penumbra::testing
