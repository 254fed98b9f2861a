// The term of equation (3.2) in GLSL against its C++ twin.
#include "render/technique/soft_texture/gl/sample_term.h"

#include <gtest/gtest.h>

#include <cmath>

#include "absl/strings/str_cat.h"
#include "render/gl/buffer.h"
#include "render/gl/draw.h"
#include "render/gl/program.h"
#include "tests/gl/display/software_context.h"
#include "tests/support/random_scene.h"

namespace penumbra::testing {
namespace {

using texture_gl::Emitter;
using texture_gl::EmitterOf;
using texture_gl::GpuEmitter;
using texture_gl::GpuLightSample;
using texture_gl::LightSamplesForGpu;
using texture_gl::SampleTerm;

constexpr char kComputeGlsl[] = R"(
layout(local_size_x = 64) in;
struct Case { LightSample s; Emitter emitter; vec4 point, normal; };
layout(std430, binding = 0) readonly buffer Cases { Case cases[]; };
layout(std430, binding = 1) buffer Results { float results[]; };
void main() {
  uint i = gl_GlobalInvocationID.x;
  Case c = cases[i];
  results[i] = SampleTerm(c.s, c.emitter, c.point.xyz, c.normal.xyz, c.normal.w != 0.0);
})";

struct Case {
  GpuLightSample sample;
  GpuEmitter emitter;
  Vec4 point, normal;  // normal.w: 1 if two-sided
};

std::vector<Case> RandomCases(int count) {
  std::vector<Case> cases;
  Dice dice(7);
  while (static_cast<int>(cases.size()) < count) {
    AreaLight light = RandomLight(dice, static_cast<int>(cases.size()) % kLightKinds);
    if (auto* rectangle = std::get_if<RectangleLight>(&light.shape)) {
      rectangle->two_sided = dice.Below(2) == 0;
    }
    const auto samples = SampleLight(light, 16, 1 + dice.Below(1000), Vec3(0));
    const Parallelogram patch{.origin = dice.InCube(1)};
    const auto converted = LightSamplesForGpu(light, samples, patch);
    const float two_sided = static_cast<float>(dice.Below(2));
    cases.push_back({converted[dice.Below(static_cast<uint32_t>(converted.size()))],
                     EmitterOf(light), Vec4(dice.InCube(2), 0), Vec4(dice.Direction(), two_sided)});
  }
  return cases;
}

// What the term would be if light came straight on: rounding is relative to that.
double Scale(const Case& c) {
  const auto kind = static_cast<Emitter>(static_cast<int>(c.emitter.kind.x));
  const DVec3 to_light = DVec3(c.sample.place) - DVec3(c.point);
  const double r2 = glm::dot(to_light, to_light);
  if (kind == Emitter::kSky) return c.sample.place.w;
  if (kind == Emitter::kSurface) return c.sample.place.w / r2;
  const double ramp = std::max(1e-3, double{c.emitter.kind.w} - c.emitter.kind.z);
  return 1 / r2 / (c.emitter.kind.z < -1 ? 1 : ramp);
}

class SampleTermTest : public SoftwareContextTest {};

TEST_F(SampleTermTest, IsTheSameInGlsl) {
  constexpr int kCases = 64 * 96;
  const std::vector<Case> cases = RandomCases(kCases);
  auto program = gl::Program::Create(
      *context_, {.compute = absl::StrCat(texture_gl::SampleTermGlsl(), kComputeGlsl)});
  ASSERT_TRUE(program.ok()) << program.status();
  auto in = gl::Buffer::Create(*context_, std::as_bytes(std::span(cases)));
  std::vector<float> results(kCases);
  auto out = gl::Buffer::Create(*context_, kCases * sizeof(float));
  ASSERT_TRUE(in.ok() && out.ok());
  in->BindStorage(*context_, 0);
  out->BindStorage(*context_, 1);
  gl::Dispatch(*context_, *program, kCases / 64);
  ASSERT_TRUE(out->Read(*context_, 0, std::as_writable_bytes(std::span(results))).ok());
  int lit = 0;
  for (int i = 0; i < kCases; ++i) {
    const Case& c = cases[i];
    const double expected =
        SampleTerm(c.sample, c.emitter, DVec3(c.point), DVec3(c.normal), c.normal.w != 0);
    lit += expected > 0;
    ASSERT_NEAR(results[i], expected, 2e-6 * Scale(c)) << "case " << i;
  }
  EXPECT_GT(lit, kCases / 3);
  EXPECT_LT(lit, kCases * 9 / 10);
}

// 1 m² of 1 W·m⁻²·sr⁻¹, 2 m straight above: 1 / 4π; tilted by 60° half of it.
TEST(SampleTermValueTest, OfAKnownPlace) {
  const AreaLight light{"l", RectangleLight{.corner = Vec3(-0.5f, 2, -0.5f)}};
  const LightSample middle{.point = Vec3(0, 2, 0)};
  const auto sample =
      LightSamplesForGpu(light, std::span(&middle, 1), Parallelogram{.origin = Vec3(0.0f)})[0];
  const GpuEmitter emitter = EmitterOf(light);
  EXPECT_NEAR(SampleTerm(sample, emitter, DVec3(0.0), DVec3(0, 1, 0), false),
              1 / (16 * std::atan(1)), 1e-7);
  const DVec3 tilted(std::sqrt(0.75), 0.5, 0);
  EXPECT_NEAR(SampleTerm(sample, emitter, DVec3(0.0), tilted, false), 0.5 / (16 * std::atan(1)),
              1e-7);
  EXPECT_EQ(SampleTerm(sample, emitter, DVec3(0.0), DVec3(0, -1, 0), false), 0);
  EXPECT_NEAR(SampleTerm(sample, emitter, DVec3(0.0), DVec3(0, -1, 0), true),
              1 / (16 * std::atan(1)), 1e-7);
}

}  // namespace
}  // namespace penumbra::testing
