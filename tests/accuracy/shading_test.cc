// Radiance summed over samples (equation 3.2) against brute force in double precision.
#include <algorithm>
#include <cmath>
#include <iostream>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "render/reference/light_integral.h"
#include "render/reference/light_quadrature.h"
#include "render/technique/technique.h"
#include "tests/accuracy/ledger.h"
#include "tests/support/random_scene.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

// An error counts in relation to a texel's radiance, or to this part of the brightest one's.
constexpr double kDarkest = 1e-3;
// The double-precision side takes its time.
constexpr uint32_t kTexelStep = 5;

constexpr const char* kKinds[] = {"rectangle", "disk", "sphere", "point", "spot", "distant"};

Artifact ComputeSum(const Scene& scene, SoftTextureParams params, int threads = 2) {
  params.radiance = true;
  params.shading = Shading::kSampleSum;
  const ArtifactSpec spec{.params = params, .light_id = "light", .receiver_id = "receiver"};
  tbb::task_arena arena(threads);
  return TechniqueFor(spec.params).Compute(scene, spec, {.arena = arena}).value();
}

const SoftShadowTexture& TextureOf(const Artifact& artifact) {
  return std::get<SoftShadowTexture>(artifact.payload);
}

DVec3 CenterOf(const ReceiverPatch& receiver, uint32_t t) {
  return DVec3(receiver.patch.origin) +
         (t % receiver.width + 0.5) / receiver.width * DVec3(receiver.patch.edge_u) +
         (t / receiver.width + 0.5) / receiver.height * DVec3(receiver.patch.edge_v);
}

DVec3 NormalOf(const ReceiverPatch& receiver) {
  return glm::normalize(glm::cross(DVec3(receiver.patch.edge_u), DVec3(receiver.patch.edge_v)));
}

// Which samples each texel sees, by computing the counts of every sample by itself: what is summed
// is tested here, and what is seen elsewhere.
std::vector<std::vector<uint8_t>> VisibleBySample(const Scene& scene, const Artifact& artifact) {
  const auto& samples = artifact.header.light_samples;
  std::vector<std::vector<uint8_t>> visible;
  for (const LightSample& sample : samples) {
    AreaLight one{"light", PointLight{.position = sample.point}};
    if (sample.at_infinity) one.shape = DistantLight{.to_light = sample.point};
    const auto with_one = scene.Apply({.upsert_lights = {one}}).value();
    const ArtifactSpec spec{SoftTextureParams{}, "light", "receiver"};
    tbb::task_arena arena(2);
    const Artifact seen =
        TechniqueFor(spec.params).Compute(*with_one, spec, {.arena = arena}).value();
    const auto& counts = TextureOf(seen).visibility.counts;
    visible.emplace_back(counts.begin(), counts.end());
  }
  return visible;
}

class Oracle {
 public:
  Oracle(const Scene& scene, const Artifact& artifact)
      : texture_(TextureOf(artifact)),
        visible_(VisibleBySample(scene, artifact)),
        points_(MeasuredSamples(texture_.light, artifact.header.light_samples,
                                DVec3(texture_.receiver.patch.At(Vec2(0.5f))))) {}

  DVec3 At(uint32_t t) const {
    std::vector<uint8_t> seen;
    for (const auto& sample : visible_) seen.push_back(sample[t]);
    const ReceiverPatch& receiver = texture_.receiver;
    const DVec3 point = CenterOf(receiver, t);
    const DVec3 n = NormalOf(receiver);
    const auto from_both = [&](std::span<const uint8_t> flags) {
      DVec3 sum = DirectRadiance(texture_.light, points_, point, n, flags);
      if (receiver.two_sided) sum += DirectRadiance(texture_.light, points_, point, -n, flags);
      return sum;
    };
    DVec3 radiance = from_both(seen);
    if (std::holds_alternative<SphereLight>(texture_.light.shape)) {
      const DVec3 all = from_both({});
      DVec3 whole = IntegratedRadiance(texture_.light, point, n);
      if (receiver.two_sided) whole += IntegratedRadiance(texture_.light, point, -n);
      for (int c = 0; c < 3; ++c) radiance[c] = all[c] > 0 ? radiance[c] / all[c] * whole[c] : -1;
    }
    return DVec3(receiver.reflectance) * radiance;
  }

 private:
  const SoftShadowTexture& texture_;
  const std::vector<std::vector<uint8_t>> visible_;
  const std::vector<QuadraturePoint> points_;
};

class ShadingTest : public ::testing::TestWithParam<int> {};

// Every texel of random scenes: the same samples, the same visibility, double precision.
TEST_P(ShadingTest, SumsWhatEachVisibleSampleSends) {
  double worst = 0;
  int shadowed = 0;
  for (uint64_t seed = GetParam(); seed < 60; seed += kLightKinds) {
    const auto scene = RandomScene(seed);
    const Artifact artifact =
        ComputeSum(*scene, {.samples = 13, .seed = seed, .form_factor_error = 0});
    const SoftShadowTexture& texture = TextureOf(artifact);
    const Oracle oracle(*scene, artifact);
    std::vector<DVec3> expected;
    double brightest = 0;
    for (uint32_t t = 0; t < texture.visibility.counts.size(); t += kTexelStep) {
      expected.push_back(oracle.At(t));
      brightest = std::max(brightest, expected.back().x);
    }
    for (size_t e = 0; e < expected.size(); ++e) {
      const size_t t = e * kTexelStep;
      const DVec3 actual(texture.radiance->texels[t]);
      ASSERT_TRUE(std::isfinite(actual.x)) << "scene " << seed;
      if (!(expected[e].x >= 0)) continue;  // inside a sphere, where samples say nothing
      shadowed += texture.visibility.counts[t] < texture.visibility.sample_count;
      const double unit = std::max(expected[e].x, kDarkest * brightest);
      if (unit > 0) worst = std::max(worst, std::abs(actual.x - expected[e].x) / unit);
      if (expected[e].x > kDarkest * brightest) {
        EXPECT_NEAR(actual.y / actual.x, expected[e].y / expected[e].x, 1e-4);
        EXPECT_NEAR(actual.z / actual.x, expected[e].z / expected[e].x, 1e-4);
      }
    }
  }
  EXPECT_GT(shadowed, 200);
  ExpectInLedger(std::string("sample_sum.") + kKinds[GetParam()] + ".relative_error", worst);
}

// With nothing in the way, 1,024 samples come to the closed form; a sphere is scaled to it, and its
// samples are measured without that at the patch's middle, where they are made for.
TEST_P(ShadingTest, ManySamplesComeToTheIntegral) {
  double worst = 0;
  for (uint64_t trial = 0; trial < 12; ++trial) {
    Dice dice(500 + trial);
    const AreaLight light = RandomLight(dice, GetParam());
    Receiver receiver = FloorReceiver("receiver", 1, 3);
    receiver.shape = Parallelogram{Vec3(-0.5f, -1, 0.6f), Vec3(1, 0.3f, 0), Vec3(0.2f, 0, -1.2f)};
    const auto scene = Scene::Empty("s")
                           ->Apply({.upsert_lights = {light}, .upsert_receivers = {receiver}})
                           .value();
    const Artifact artifact = ComputeSum(*scene, {.samples = 1024, .seed = trial});
    const SoftShadowTexture& texture = TextureOf(artifact);
    const DVec3 n = NormalOf(texture.receiver);
    for (uint32_t t = 0; t < 9; ++t) {
      const DVec3 point = CenterOf(texture.receiver, t);
      const DVec3 expected =
          IntegratedRadiance(light, point, n) + IntegratedRadiance(light, point, -n);
      if (expected.x < 1e-4) continue;
      worst = std::max(worst, std::abs(texture.radiance->texels[t].x / expected.x - 1));
    }
    if (std::holds_alternative<SphereLight>(light.shape)) {
      const DVec3 middle(texture.receiver.patch.At(Vec2(0.5f)));
      const auto points = MeasuredSamples(light, artifact.header.light_samples, middle);
      const DVec3 expected =
          IntegratedRadiance(light, middle, n) + IntegratedRadiance(light, middle, -n);
      const DVec3 sum = DirectRadiance(light, points, middle, n, {}) +
                        DirectRadiance(light, points, middle, -n, {});
      worst = std::max(worst, std::abs(sum.x / expected.x - 1));
    }
  }
  ExpectInLedger(std::string("sample_sum.") + kKinds[GetParam()] + ".sampling_error_1024", worst);
}

INSTANTIATE_TEST_SUITE_P(EveryLight, ShadingTest, ::testing::Range(0, kLightKinds),
                         [](const auto& test) { return std::string(kKinds[test.param]); });

}  // namespace
}  // namespace penumbra::testing
