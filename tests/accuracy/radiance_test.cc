// The closed forms of unoccluded light against integrals in double precision.
#include <algorithm>
#include <array>
#include <string>

#include "absl/strings/str_cat.h"
#include "gtest/gtest.h"
#include "render/reference/light_integral.h"
#include "render/scene/unoccluded_light.h"
#include "render/technique/technique.h"
#include "tests/accuracy/ledger.h"
#include "tests/support/random_scene.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

constexpr std::array<const char*, kLightKinds> kKinds = {"rectangle", "disk", "sphere",
                                                         "point",     "spot", "distant"};

// Below this part of what the light gives a surface that faces it, an error counts relative to that
// part: hardly a sliver of the light is above the horizon there.
constexpr double kDarkest = 1e-4;

double Brightest(const AreaLight& light, Vec3 point) {
  double most = 0;
  Dice dice(99);
  for (int k = 0; k < 20; ++k) {
    const Vec3 normal = dice.Direction();
    most = std::max(most, IntegratedRadiance(light, DVec3(point), DVec3(normal)).x);
  }
  return most;
}

class RadianceTest : public ::testing::TestWithParam<int> {};

// Any place and normal around the light, so that many have the horizon through it.
TEST_P(RadianceTest, AgreesWithTheIntegral) {
  Dice dice(1000 + GetParam());
  double worst = 0;
  int lit = 0;
  for (int trial = 0; trial < 120; ++trial) {
    const AreaLight light = RandomLight(dice, GetParam());
    const Vec3 point = dice.InCube(1), normal = dice.Direction();
    if (const auto* sphere = std::get_if<SphereLight>(&light.shape)) {
      if (glm::distance(sphere->center, point) < 1.01f * sphere->radius) continue;
    }
    const DVec3 expected = IntegratedRadiance(light, DVec3(point), DVec3(normal));
    const DVec3 actual(UnoccludedRadiance(light, point, normal));
    const double unit = std::max(expected.x, kDarkest * Brightest(light, point));
    lit += expected.x > 0;
    if (unit == 0) {
      EXPECT_EQ(actual.x, 0);
      continue;
    }
    for (int c = 0; c < 3; ++c) {
      const double scale = unit * (expected.x > 0 ? expected[c] / expected.x : 1);
      ASSERT_TRUE(std::isfinite(actual[c]));
      worst = std::max(worst, std::abs(actual[c] - expected[c]) / scale);
    }
  }
  EXPECT_GT(lit, 30);
  ExpectInLedger(std::string("radiance.") + kKinds[GetParam()] + ".relative_error", worst);
}

// The texture as delivered: every texel of a coloured receiver with nothing in the way.
TEST_P(RadianceTest, TheTextureOfAnUnoccludedReceiver) {
  double worst = 0;
  int lit = 0;
  for (uint64_t trial = 0; trial < 10; ++trial) {
    Dice dice(2000 + trial);
    const AreaLight light = RandomLight(dice, GetParam());
    Receiver receiver = FloorReceiver("receiver", 1.5f, 5);
    receiver.width = 7;
    receiver.two_sided = trial % 2 == 0;
    receiver.reflectance = Vec3(0.9f, 0.5f, 0.2f);
    const auto scene = Scene::Empty("s")
                           ->Apply({.upsert_lights = {light}, .upsert_receivers = {receiver}})
                           .value();
    const ArtifactSpec spec{SoftTextureParams{.samples = 4, .radiance = true}, "light", "receiver"};
    tbb::task_arena arena(1);
    const Artifact artifact =
        TechniqueFor(spec.params).Compute(*scene, spec, {.arena = arena}).value();
    const auto& texture = std::get<SoftShadowTexture>(artifact.payload);
    ASSERT_TRUE(texture.radiance);
    for (uint32_t t = 0; t < 7 * 5; ++t) {
      // In double precision, as the texture is computed.
      const Parallelogram& patch = texture.receiver.patch;
      const DVec3 at = DVec3(patch.origin) + (t % 7 + 0.5) / 7 * DVec3(patch.edge_u) +
                       (t / 7 + 0.5) / 5 * DVec3(patch.edge_v);
      DVec3 expected = IntegratedRadiance(light, at, DVec3(0, 1, 0));
      if (receiver.two_sided) expected += IntegratedRadiance(light, at, DVec3(0, -1, 0));
      expected *= DVec3(receiver.reflectance);
      const DVec3 actual(texture.radiance->texels[t]);
      if (expected.x < kDarkest) continue;
      ++lit;
      for (int c = 0; c < 3; ++c) {
        ASSERT_TRUE(std::isfinite(actual[c]));
        worst = std::max(worst, std::abs(actual[c] / expected[c] - 1));
      }
    }
  }
  EXPECT_GT(lit, 50);
  ExpectInLedger(absl::StrCat("radiance_texture.", kKinds[GetParam()], ".relative_error"), worst);
}

INSTANTIATE_TEST_SUITE_P(EveryLight, RadianceTest, ::testing::Range(0, kLightKinds),
                         [](const auto& test) { return std::string(kKinds[test.param]); });

}  // namespace
}  // namespace penumbra::testing
