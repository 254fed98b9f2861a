// What radiance textures hold, by either formula.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "render/scene/field_error.h"
#include "render/scene/unoccluded_light.h"
#include "render/technique/technique.h"
#include "tests/unit/technique/soft_texture_scenes.h"

namespace penumbra::testing {
namespace {

using ::testing::HasSubstr;

constexpr double kPi = std::numbers::pi;

SoftTextureParams SumOf(uint32_t samples) {
  return {.samples = samples, .radiance = true, .shading = Shading::kSampleSum};
}

const std::vector<Vec3>& RadianceOf(const Artifact& artifact) {
  return TextureOf(artifact).radiance->texels;
}

SceneDelta BoxesUnderALamp() {
  SceneDelta delta = RandomBoxes(20, 9);
  delta.upsert_receivers = {Floor(131, 67)};
  delta.upsert_lights = {Ceiling()};
  return delta;
}

// One sample straight above a texel: A / (π h²), by hand.
TEST(SampleSum, IsTheKernelForOneSample) {
  SceneDelta delta;
  delta.upsert_receivers = {Floor(3, 3)};
  delta.upsert_receivers[0].reflectance = Vec3(0.5f);
  delta.upsert_lights = {{.id = "light",
                          .shape = RectangleLight{.corner = Vec3(-1e-3f, 2, -1e-3f),
                                                  .edge_u = Vec3(2e-3f, 0, 0),
                                                  .edge_v = Vec3(0, 0, 2e-3f),
                                                  .radiance = Vec3(3, 5, 7)}}};
  const Artifact artifact = Compute(*SceneOf(delta), SumOf(1)).value();
  const double middle = 0.5 * 4e-6 / (kPi * 4);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(RadianceOf(artifact)[4][c], (3 + 2 * c) * middle, 1e-3 * middle);
  }
  // Two metres aside: cos θ = cos θ' = h / r = 1 / √2 and r² = 8.
  EXPECT_NEAR(RadianceOf(artifact)[5].x, 3 * middle / 4, 1e-2 * middle);
}

TEST(SampleSum, HasTheSameBitsForAnyNumberOfThreadsAndPasses) {
  const auto scene = SceneOf(BoxesUnderALamp());
  const Artifact one = Compute(*scene, SumOf(100), 1).value();
  for (const int threads : {2, 4}) {
    EXPECT_EQ(RadianceOf(Compute(*scene, SumOf(100), threads).value()), RadianceOf(one));
  }
  tbb::task_arena arena(2);
  std::vector<Artifact> passes;
  const ArtifactSpec spec{SumOf(100), "light", "floor"};
  const ComputeContext context{.arena = arena,
                               .progress = [&](Artifact pass) { passes.push_back(pass); }};
  const auto progressive = TechniqueFor(spec.params).Compute(*scene, spec, context);
  EXPECT_EQ(RadianceOf(*progressive), RadianceOf(one));
  // A coarse pass is as bright as the last one: its sum is over fewer samples.
  ASSERT_EQ(passes.size(), 2u);
  const auto mean = [](const std::vector<Vec3>& texels) {
    double sum = 0;
    for (const Vec3 texel : texels) sum += texel.x;
    return sum / static_cast<double>(texels.size());
  };
  EXPECT_NEAR(mean(RadianceOf(passes[0])), mean(RadianceOf(one)), 0.05 * mean(RadianceOf(one)));
}

// Edits computed over kept shadows against computing anew, bit for bit.
TEST(SampleSum, IsTheSameOverKeptShadows) {
  auto scene = SceneOf(BoxesUnderALamp());
  MemoryBudget budget(size_t{64} << 20);
  TechniqueMemory memory{budget, nullptr};
  tbb::task_arena arena(2);
  const ArtifactSpec spec{SumOf(40), "light", "floor"};
  for (int step = 0; step < 6; ++step) {
    Instance box = *scene->FindInstance(step < 4 ? "box3" : "box5");
    box.world_from_mesh[3] += Vec3(0.1f, 0, 0.05f);
    scene = scene->Apply({.upsert_instances = {box}}).value();
    const Technique& technique = TechniqueFor(spec.params);
    const Artifact anew = technique.Compute(*scene, spec, {.arena = arena}).value();
    const Artifact kept =
        technique.Compute(*scene, spec, {.arena = arena, .memory = &memory}).value();
    EXPECT_EQ(RadianceOf(kept), RadianceOf(anew)) << "step " << step;
  }
}

TEST(SampleSum, IsDarkWhereCountsAreZeroAndFullWhereAllAreSeen) {
  SceneDelta delta = BoxesUnderALamp();
  const auto with = SceneOf(delta);
  delta.upsert_instances.clear();
  const Artifact shadowed = Compute(*with, SumOf(64)).value();
  const Artifact open = Compute(*SceneOf(delta), SumOf(64)).value();
  const auto& counts = TextureOf(shadowed).visibility.counts;
  int dark = 0, full = 0, between = 0;
  for (size_t t = 0; t < counts.size(); ++t) {
    if (counts[t] == 0) {
      EXPECT_EQ(RadianceOf(shadowed)[t], Vec3(0.0f));
      ++dark;
    } else if (counts[t] == 64) {
      EXPECT_EQ(RadianceOf(shadowed)[t], RadianceOf(open)[t]);
      ++full;
    } else {
      EXPECT_LT(RadianceOf(shadowed)[t].x, RadianceOf(open)[t].x);
      ++between;
    }
  }
  EXPECT_GT(dark, 20);
  EXPECT_GT(full, 20);
  EXPECT_GT(between, 20);
}

// A lamp on edge, half of it under the floor: the part below sends nothing to the front, whichever
// way the samples fall, and the back gets the rest.
TEST(SampleSum, LeavesOutWhatIsBehindThePlane) {
  SceneDelta delta;
  Receiver floor = Floor(9, 9);
  floor.two_sided = false;
  delta.upsert_receivers = {floor};
  RectangleLight lamp{.corner = Vec3(-1, -2, -2), .edge_u = Vec3(2, 0, 0), .edge_v = Vec3(0, 4, 0)};
  delta.upsert_lights = {{.id = "light", .shape = lamp}};
  const Artifact crossing = Compute(*SceneOf(delta), SumOf(1024)).value();
  lamp.corner.y = 0;
  lamp.edge_v.y = 2;
  delta.upsert_lights = {{.id = "light", .shape = lamp}};
  const Artifact upper = Compute(*SceneOf(delta), SumOf(512)).value();
  delta.upsert_receivers[0].two_sided = true;
  lamp.corner.y = -2;
  lamp.edge_v.y = 4;
  delta.upsert_lights = {{.id = "light", .shape = lamp}};
  const Artifact both = Compute(*SceneOf(delta), SumOf(1024)).value();
  for (size_t t = 0; t < 81; ++t) {
    const float expected = RadianceOf(upper)[t].x;
    EXPECT_NEAR(RadianceOf(crossing)[t].x, expected, 0.05f * expected + 1e-3f) << t;
    EXPECT_NEAR(RadianceOf(both)[t].x, 2 * expected, 0.1f * expected + 2e-3f) << t;
  }
  // All of it below: nothing at all.
  lamp.corner.y = -5;
  delta.upsert_receivers[0].two_sided = false;
  delta.upsert_lights = {{.id = "light", .shape = lamp}};
  const Artifact below = Compute(*SceneOf(delta), SumOf(64)).value();
  for (const Vec3 texel : RadianceOf(below)) EXPECT_EQ(texel, Vec3(0.0f));
}

TEST(SampleSum, KnowsTheFrontOfALight) {
  SceneDelta delta;
  delta.upsert_receivers = {Floor(5, 5)};
  // edge_u × edge_v points down.
  RectangleLight lamp{.corner = Vec3(-1, 3, -1), .edge_u = Vec3(2, 0, 0), .edge_v = Vec3(0, 0, 2)};
  lamp.two_sided = true;
  delta.upsert_lights = {{.id = "light", .shape = lamp}};
  const Artifact two = Compute(*SceneOf(delta), SumOf(16)).value();
  lamp.two_sided = false;
  delta.upsert_lights = {{.id = "light", .shape = lamp}};
  const Artifact front = Compute(*SceneOf(delta), SumOf(16)).value();
  std::swap(lamp.edge_u, lamp.edge_v);
  delta.upsert_lights = {{.id = "light", .shape = lamp}};
  const Artifact back = Compute(*SceneOf(delta), SumOf(16)).value();
  EXPECT_EQ(RadianceOf(front), RadianceOf(two));
  for (const Vec3 texel : RadianceOf(back)) EXPECT_EQ(texel, Vec3(0.0f));
  EXPECT_GT(RadianceOf(front)[12].x, 0.05f);
}

TEST(SampleSum, StopsWhenAsked) {
  std::stop_source source;
  source.request_stop();
  tbb::task_arena arena(1);
  const ArtifactSpec spec{SumOf(64), "light", "floor"};
  const ComputeContext context{.arena = arena, .stop = source.get_token()};
  EXPECT_TRUE(absl::IsCancelled(
      TechniqueFor(spec.params).Compute(*SceneOf(BoxesUnderALamp()), spec, context).status()));
}

TEST(Ambient, IsAddedBeforeTheReflectance) {
  SceneDelta delta = BoxesUnderALamp();
  delta.upsert_receivers[0].reflectance = Vec3(0.5f, 0.25f, 0);
  const auto scene = SceneOf(delta);
  for (const Shading shading : {Shading::kProduct, Shading::kSampleSum}) {
    SoftTextureParams params{.samples = 16, .radiance = true, .shading = shading};
    const Artifact without = Compute(*scene, params).value();
    params.ambient = Vec3(1, 2, 4);
    const Artifact with = Compute(*scene, params).value();
    for (size_t t = 0; t < RadianceOf(with).size(); ++t) {
      const Vec3 added = RadianceOf(with)[t] - RadianceOf(without)[t];
      ASSERT_LT(glm::length(added - Vec3(0.5f, 0.5f, 0)), 1e-6f) << t;
    }
  }
}

TEST(FormFactorError, BoundsTheRadianceOfTheProduct) {
  const auto scene = SceneOf(BoxesUnderALamp());
  SoftTextureParams params{.samples = 16, .radiance = true, .form_factor_error = 0};
  const Artifact exact = Compute(*scene, params).value();
  for (const float bound : {1e-3f, 1e-2f}) {
    params.form_factor_error = bound;
    const Artifact near = Compute(*scene, params).value();
    float worst = 0;
    for (size_t t = 0; t < RadianceOf(near).size(); ++t) {
      const float expected = RadianceOf(exact)[t].x;
      const float error = std::abs(RadianceOf(near)[t].x - expected);
      ASSERT_LE(error, (bound + 1e-6f) * expected) << t;
      worst = std::max(worst, error);
    }
    EXPECT_GT(worst, 0) << "nothing was interpolated";
  }
}

TEST(Output, IsRoundedWithinItsError) {
  const auto scene = SceneOf(BoxesUnderALamp());
  for (const Shading shading : {Shading::kProduct, Shading::kSampleSum}) {
    SoftTextureParams params{.samples = 16, .radiance = true, .shading = shading};
    const Artifact exact = Compute(*scene, params).value();
    const auto worst = [&](RadianceFormat format, float given_scale) {
      params.output = format;
      params.output_scale = given_scale;
      const Artifact rounded = Compute(*scene, params).value();
      EXPECT_EQ(TextureOf(rounded).radiance->format, format);
      double most = 0;
      for (size_t t = 0; t < RadianceOf(rounded).size(); ++t) {
        const double error = RadianceOf(rounded)[t].x - RadianceOf(exact)[t].x;
        most = std::max(most, std::abs(error) / TextureOf(rounded).radiance->scale);
      }
      return most;
    };
    EXPECT_LE(worst(RadianceFormat::kUnorm8, 0), 1 / 509.0);
    EXPECT_GT(worst(RadianceFormat::kUnorm8, 0), 1 / 600.0);
    EXPECT_LE(worst(RadianceFormat::kUnorm16, 0), 1 / 130000.0);
    EXPECT_LE(worst(RadianceFormat::kUnorm16, 3), 1 / 130000.0);
    EXPECT_LE(worst(RadianceFormat::kHalf, 0), 1 / 2048.0);
    EXPECT_GT(worst(RadianceFormat::kHalf, 0), 0);
  }
}

// The scale is the largest of what nothing hides: it is used up, and occluders do not change it.
TEST(Output, HasAScaleThatOccludersDoNotChange) {
  SceneDelta delta = BoxesUnderALamp();
  const auto with = SceneOf(delta);
  delta.upsert_instances.clear();
  const auto without = SceneOf(delta);
  for (const Shading shading : {Shading::kProduct, Shading::kSampleSum}) {
    SoftTextureParams params{.samples = 16, .radiance = true, .shading = shading};
    params.ambient = Vec3(0.1f);
    const Artifact exact = Compute(*without, params).value();
    params.output = RadianceFormat::kUnorm16;
    const Artifact a = Compute(*with, params).value(), b = Compute(*without, params).value();
    const float scale = TextureOf(a).radiance->scale;
    EXPECT_EQ(scale, TextureOf(b).radiance->scale);
    float largest = 0;
    for (const Vec3 texel : RadianceOf(exact)) largest = std::max(largest, texel.x);
    EXPECT_NEAR(scale, largest, 1e-6f * largest);
    EXPECT_EQ(a.header.parameters.at("output"), "unorm16");
    EXPECT_NEAR(std::stof(a.header.parameters.at("output_scale")), scale, 1e-7f * scale);
  }
}

TEST(Output, CountsThatDoNotFitAreRefused) {
  const auto scene = SceneOf(BoxesUnderALamp());
  EXPECT_EQ(TextureOf(Compute(*scene, {.count_bits = CountBits::k16}).value()).count_bits, 16u);
  EXPECT_TRUE(Compute(*scene, {.samples = 255, .count_bits = CountBits::k8}).ok());
  const auto status = Compute(*scene, {.samples = 256, .count_bits = CountBits::k8}).status();
  EXPECT_EQ(ErrorFieldPath(status), "soft_texture.count_bits");
  EXPECT_THAT(std::string(status.message()), HasSubstr("found 8 for 256 light samples"));
}

TEST(ShadingParameters, AreCheckedAndTold) {
  const auto scene = SceneOf(BoxesUnderALamp());
  const auto expect_range = [&](const SoftTextureParams& params, const char* field) {
    const absl::Status status = Compute(*scene, params).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_EQ(ErrorFieldPath(status), field);
    EXPECT_EQ(ErrorReason(status), "RANGE");
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  expect_range({.form_factor_error = -1e-6f}, "soft_texture.form_factor_error");
  expect_range({.form_factor_error = 0.11f}, "soft_texture.form_factor_error");
  expect_range({.form_factor_error = nan}, "soft_texture.form_factor_error");
  expect_range({.ambient = Vec3(0, -1, 0)}, "soft_texture.ambient");
  expect_range({.ambient = Vec3(0, 0, nan)}, "soft_texture.ambient");
  expect_range({.output_scale = -1}, "soft_texture.output_scale");
  expect_range({.output_scale = nan}, "soft_texture.output_scale");
  const Artifact artifact = Compute(*scene, SumOf(4)).value();
  EXPECT_EQ(artifact.header.parameters.at("shading"), "sample_sum");
  EXPECT_EQ(artifact.header.parameters.at("ambient"), "0 0 0");
}

}  // namespace
}  // namespace penumbra::testing
