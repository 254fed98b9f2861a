// One texture for all lights of a scene.
#include "render/technique/soft_texture/all_lights.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "render/scene/field_error.h"
#include "tests/unit/technique/soft_texture_scenes.h"

namespace penumbra::testing {
namespace {

using ::testing::HasSubstr;

absl::StatusOr<Artifact> ComputeOf(const std::string& light_id, const Scene& scene,
                                   const SoftTextureParams& params,
                                   TechniqueMemory* memory = nullptr) {
  tbb::task_arena arena(2);
  const ArtifactSpec spec{params, light_id, "floor"};
  return TechniqueFor(spec.params).Compute(scene, spec, {.arena = arena, .memory = memory});
}

const std::vector<Vec3>& RadianceOf(const Artifact& artifact) {
  return TextureOf(artifact).radiance->texels;
}

// A red lamp on the left, a blue one on the right, and boxes between.
SceneDelta RedAndBlue() {
  SceneDelta delta = RandomBoxes(12, 5);
  Receiver floor = Floor(70, 50);
  floor.reflectance = Vec3(0.8f, 0.5f, 0.25f);
  delta.upsert_receivers = {floor};
  delta.upsert_lights = {
      {.id = "blue", .shape = SphereLight{.center = Vec3(2, 4, 0), .radiance = Vec3(0, 0, 9)}},
      {.id = "red",
       .shape = RectangleLight{.corner = Vec3(-3, 4, -0.5f),
                               .edge_u = Vec3(1, 0, 0),
                               .edge_v = Vec3(0, 0, 1),
                               .radiance = Vec3(7, 0, 0)}},
      {.id = "spot", .shape = SpotLight{.position = Vec3(0, 3, 0), .intensity = Vec3(0, 1, 0)}}};
  return delta;
}

TEST(AllLights, AreTheSumOfEachInItsColour) {
  const auto scene = SceneOf(RedAndBlue());
  for (const Shading shading : {Shading::kProduct, Shading::kSampleSum}) {
    SoftTextureParams params{.samples = 30, .radiance = true, .shading = shading};
    const Artifact red = ComputeOf("red", *scene, params).value();
    const Artifact blue = ComputeOf("blue", *scene, params).value();
    const Artifact spot = ComputeOf("spot", *scene, params).value();
    params.radiance = false;  // it is there all the same
    params.ambient = Vec3(0.1f, 0, 0);
    const Artifact all = ComputeOf("*", *scene, params).value();
    const VisibilityMap& map = TextureOf(all).visibility;
    EXPECT_EQ(map.sample_count, 61u);
    int purple = 0, only_red = 0, only_blue = 0;
    for (size_t t = 0; t < map.counts.size(); ++t) {
      EXPECT_EQ(map.counts[t], TextureOf(red).visibility.counts[t] +
                                   TextureOf(blue).visibility.counts[t] +
                                   TextureOf(spot).visibility.counts[t]);
      const Vec3 expected =
          Vec3(0.08f, 0, 0) + RadianceOf(red)[t] + RadianceOf(blue)[t] + RadianceOf(spot)[t];
      ASSERT_LT(glm::length(RadianceOf(all)[t] - expected), 1e-6f * (1 + glm::length(expected)));
      EXPECT_EQ(RadianceOf(red)[t].z, 0);
      EXPECT_EQ(RadianceOf(blue)[t].x, 0);
      const Vec3 light = RadianceOf(all)[t] - Vec3(0.08f, 0, 0);
      purple += light.x > 0.02f && light.z > 0.01f;
      only_red += light.x > 0.02f && light.z < 1e-5f;
      only_blue += light.x < 1e-5f && light.z > 0.01f;
    }
    EXPECT_GT(purple, 100);
    EXPECT_GT(only_red, 5);
    EXPECT_GT(only_blue, 5);
  }
}

TEST(AllLights, TellWhoseSamplesAreWhose) {
  const auto scene = SceneOf(RedAndBlue());
  const Artifact all = ComputeOf("*", *scene, {.samples = 30}).value();
  const Artifact blue = ComputeOf("blue", *scene, {.samples = 30}).value();
  const ArtifactHeader& header = all.header;
  EXPECT_EQ(header.light_id, "*");
  EXPECT_EQ(header.parameters.at("lights"), "blue:30 red:30 spot:1");
  EXPECT_EQ(header.samples_requested, 61u);
  ASSERT_EQ(header.light_samples.size(), 61u);
  for (size_t s = 0; s < 30; ++s) {
    EXPECT_EQ(header.light_samples[s].point, blue.header.light_samples[s].point);
  }
  EXPECT_EQ(header.light_samples[60].point, Vec3(0, 3, 0));
  EXPECT_FLOAT_EQ(header.light_samples[60].weight, 1 / 61.0f);
  EXPECT_TRUE(header.is_final);
  EXPECT_EQ(TextureOf(all).light.id, "*");
}

TEST(AllLights, AreRoundedOnce) {
  const auto scene = SceneOf(RedAndBlue());
  SoftTextureParams params{.samples = 16, .radiance = true};
  const Artifact exact = ComputeOf("*", *scene, params).value();
  params.output = RadianceFormat::kUnorm8;
  const Artifact rounded = ComputeOf("*", *scene, params).value();
  const float scale = TextureOf(rounded).radiance->scale;
  float largest = 0;
  for (size_t t = 0; t < RadianceOf(exact).size(); ++t) {
    for (int c = 0; c < 3; ++c) {
      ASSERT_NEAR(RadianceOf(rounded)[t][c], RadianceOf(exact)[t][c], scale / 509);
      largest = std::max(largest, RadianceOf(exact)[t][c]);
    }
  }
  EXPECT_LE(largest, scale);
  EXPECT_GT(largest, scale / 4);
}

TEST(AllLights, AreTheSameOverKeptShadows) {
  auto scene = SceneOf(RedAndBlue());
  MemoryBudget budget(size_t{64} << 20);
  TechniqueMemory memory{budget, nullptr};
  const SoftTextureParams params{.samples = 20, .radiance = true, .shading = Shading::kSampleSum};
  for (int step = 0; step < 5; ++step) {
    Instance box = *scene->FindInstance("box3");
    box.world_from_mesh[3] += Vec3(0.1f, 0, 0);
    SceneDelta delta{.upsert_instances = {box}};
    if (step == 3) delta.remove_lights = {"spot"};
    scene = scene->Apply(delta).value();
    const Artifact kept = ComputeOf("*", *scene, params, &memory).value();
    const Artifact anew = ComputeOf("*", *scene, params).value();
    EXPECT_EQ(RadianceOf(kept), RadianceOf(anew)) << step;
    EXPECT_EQ(TextureOf(kept).visibility.counts, TextureOf(anew).visibility.counts) << step;
  }
}

// The coarse artifacts of a computation, and the final one last.
std::vector<Artifact> PassesOf(const Scene& scene, const ArtifactSpec& spec,
                               TechniqueMemory* memory, double tick_ms = 0) {
  tbb::task_arena arena(2);
  std::vector<Artifact> passes;
  double now = 0;
  const ComputeContext context{
      .arena = arena,
      .progress = [&](Artifact pass) { passes.push_back(std::move(pass)); },
      .now_ms = [&] { return now += tick_ms; },
      .memory = memory};
  passes.push_back(TechniqueFor(spec.params).Compute(scene, spec, context).value());
  return passes;
}

// More lights than can stand between the passes.
SceneDelta ManyLamps() {
  SceneDelta delta = RedAndBlue();
  for (int i = 0; i < 9; ++i) {
    const auto at = static_cast<float>(i);
    delta.upsert_lights.push_back(
        {.id = "lamp" + std::to_string(i),
         .shape = SphereLight{
             .center = Vec3(at - 4, 3, 0.2f * at), .radius = 0.3f, .radiance = Vec3(3)}});
  }
  return delta;
}

TEST(AllLights, ComeAtFirstWithFewSamplesOfEach) {
  for (const SceneDelta& lights : {RedAndBlue(), ManyLamps()}) {
    const auto scene = SceneOf(lights);
    for (const Shading shading : {Shading::kProduct, Shading::kSampleSum}) {
      const SoftTextureParams params{.samples = 600, .shading = shading};
      const auto passes = PassesOf(*scene, {params, "*", "floor"}, nullptr);
      ASSERT_EQ(passes.size(), 2u);
      const uint32_t points = 1, areas = static_cast<uint32_t>(scene->lights().size()) - points;
      for (uint32_t pass = 0; pass < 2; ++pass) {
        const ArtifactHeader& header = passes[pass].header;
        EXPECT_EQ(header.pass, pass);
        EXPECT_EQ(header.is_final, pass == 1);
        EXPECT_EQ(header.samples_requested, 600 * areas + points);
        EXPECT_EQ(header.light_samples.size(), (pass == 0 ? 8 : 600) * areas + points);
      }
      EXPECT_GT(passes[0].header.error_estimate, 4 * passes[1].header.error_estimate);

      // The same samples, whether they were counted twice or not.
      const Artifact whole = ComputeOf("*", *scene, params).value();
      EXPECT_EQ(RadianceOf(passes[1]), RadianceOf(whole));
      EXPECT_EQ(TextureOf(passes[1]).visibility.counts, TextureOf(whole).visibility.counts);
      double difference = 0, sum = 0;
      for (size_t t = 0; t < RadianceOf(whole).size(); ++t) {
        difference += glm::length(RadianceOf(passes[0])[t] - RadianceOf(whole)[t]);
        sum += glm::length(RadianceOf(whole)[t]);
      }
      EXPECT_GT(difference, 0);
      EXPECT_LT(difference, 0.05 * sum) << "as bright as in the end, but for the noise";
    }
  }
}

TEST(AllLights, ShareATimeBudget) {
  const auto scene = SceneOf(RedAndBlue());
  MemoryBudget none(0);
  TechniqueMemory memory{none};
  ArtifactSpec spec{SoftTextureParams{.samples = 500}, "*", "floor"};
  spec.time_budget_ms = 300;
  const auto first = [&](double tick_ms) {
    return PassesOf(*scene, spec, &memory, tick_ms)[0].header.parameters.at("lights");
  };
  EXPECT_EQ(first(1), "blue:8 red:8 spot:1");    // nothing is known yet
  EXPECT_EQ(first(1), "blue:32 red:32 spot:1");  // there was time for more, but not all at once
  first(1e6);
  EXPECT_EQ(first(1), "blue:1 red:1 spot:1");  // the last one took far too long
}

TEST(AllLights, HaveToFit) {
  SceneDelta delta = RedAndBlue();
  const auto few = SceneOf(delta);
  auto status = ComputeOf("*", *few, {.samples = 200, .count_bits = CountBits::k8}).status();
  EXPECT_EQ(ErrorFieldPath(status), "soft_texture.count_bits");
  EXPECT_THAT(std::string(status.message()), HasSubstr("found 8 for 401 light samples"));
  EXPECT_TRUE(ComputeOf("*", *few, {.samples = 127, .count_bits = CountBits::k8}).ok());
  for (int i = 0; i < 60; ++i) {
    AreaLight lamp = Ceiling();
    lamp.id = "lamp" + std::to_string(i);
    delta.upsert_lights.push_back(lamp);
  }
  status = ComputeOf("*", *SceneOf(delta), {.samples = 1024}).status();
  EXPECT_EQ(ErrorFieldPath(status), "soft_texture.samples");
  EXPECT_THAT(std::string(status.message()), HasSubstr("need at most 52000"));
  delta.upsert_lights.clear();
  status = ComputeOf("*", *SceneOf(delta), {}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(ErrorFieldPath(status), "light_id");
}

}  // namespace
}  // namespace penumbra::testing
