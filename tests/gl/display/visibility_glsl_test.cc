// The GLSL look-up of counts against Visibility() and against a bilinear filter written out.
#include "client/display/visibility_glsl.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <span>
#include <vector>

#include "absl/strings/str_cat.h"
#include "render/gl/buffer.h"
#include "render/gl/draw.h"
#include "render/gl/program.h"
#include "tests/gl/display/small_scenes.h"
#include "tests/gl/display/software_context.h"

namespace penumbra {
namespace {

constexpr int kPoints = 8192;
constexpr uint32_t kSamples = 37;
constexpr uint32_t kFirstTexel = 6;  // something else lies before the counts

constexpr char kComputeGlsl[] = R"(
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer Receivers { Receiver receivers[]; };
layout(std430, binding = 2) readonly buffer Points { vec4 points[]; };
layout(std430, binding = 3) buffer Results { vec4 results[]; };
void main() {
  uint i = gl_GlobalInvocationID.x;
  vec2 uv = UvOnReceiver(receivers[0], points[i].xyz);
  results[i] = vec4(uv, Visibility(receivers[0], uv), SmoothVisibility(receivers[0], uv));
})";

constexpr char kCoverageGlsl[] = R"(
layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer Receivers { Receiver receivers[]; };
layout(std430, binding = 2) readonly buffer Points { vec4 points[]; };
layout(std430, binding = 3) buffer Results { vec4 results[]; };
void main() {
  uint i = gl_GlobalInvocationID.x;
  vec2 uv = UvOnReceiver(receivers[0], points[i].xyz);
  results[i] = vec4(uv, float(Coverage(receivers[0], uv)), Visibility(receivers[0], uv));
})";

class VisibilityGlslTest : public SoftwareContextTest {
 protected:
  std::vector<Vec4> Run(const SoftShadowTexture& texture, const std::vector<Vec4>& points,
                        const char* compute = kComputeGlsl) {
    const GpuReceiver receiver = ToGpu(texture, kFirstTexel);
    std::vector<uint16_t> counts(kFirstTexel, 0xffff);
    counts.insert(counts.end(), texture.visibility.counts.begin(), texture.visibility.counts.end());
    if (counts.size() % 2 != 0) counts.push_back(0xffff);
    if (texture.coverage) {
      const auto bytes = texture.coverage->bytes();
      for (size_t k = 0; k < bytes.size(); k += 2) {
        const unsigned high = k + 1 < bytes.size() ? bytes[k + 1] : 0u;
        counts.push_back(static_cast<uint16_t>(bytes[k] | high << 8));
      }
      if (counts.size() % 2 != 0) counts.push_back(0);
      EXPECT_EQ(counts.size(), kFirstTexel + PlacesOf(texture));
    }
    auto program =
        gl::Program::Create(*context_, {.compute = absl::StrCat(VisibilityGlsl(0), compute)});
    auto count_buffer = gl::Buffer::Create(*context_, std::as_bytes(std::span(counts)));
    auto receiver_buffer = gl::Buffer::Create(*context_, std::as_bytes(std::span(&receiver, 1)));
    auto point_buffer = gl::Buffer::Create(*context_, std::as_bytes(std::span(points)));
    std::vector<Vec4> results(points.size());
    auto result_buffer = gl::Buffer::Create(*context_, results.size() * sizeof(Vec4));
    EXPECT_TRUE(program.ok()) << program.status();
    if (!program.ok() || !count_buffer.ok() || !receiver_buffer.ok() || !point_buffer.ok() ||
        !result_buffer.ok()) {
      return {};
    }
    count_buffer->BindStorage(*context_, 0);
    receiver_buffer->BindStorage(*context_, 1);
    point_buffer->BindStorage(*context_, 2);
    result_buffer->BindStorage(*context_, 3);
    gl::Dispatch(*context_, *program, static_cast<uint32_t>(points.size() / 64));
    EXPECT_TRUE(result_buffer->Read(*context_, 0, std::as_writable_bytes(std::span(results))).ok());
    return results;
  }
};

// A skewed patch of odd sides: a transposed or mirrored look-up cannot pass.
std::shared_ptr<const Artifact> SkewedArtifact() {
  const auto scene =
      SceneOf({.upsert_lights = {{.id = "l", .shape = PointLight{}}},
               .upsert_receivers = {{.id = "r",
                                     .shape = Parallelogram{.origin = {1, 2, -3},
                                                            .edge_u = {2, 0.3f, 0.1f},
                                                            .edge_v = {0.7f, 0.2f, -1.5f}},
                                     .width = 13,
                                     .height = 7}}});
  std::mt19937 engine(7);
  return ArtifactOf(*scene, "l", "r", kSamples,
                    [&](uint32_t, uint32_t) { return engine() % (kSamples + 1); });
}

double Smooth(const VisibilityMap& map, Vec2 uv) {
  const double x = uv.x * map.width - 0.5, y = uv.y * map.height - 0.5;
  double sum = 0;
  for (int dj = 0; dj < 2; ++dj) {
    for (int di = 0; di < 2; ++di) {
      const double i = std::floor(x) + di, j = std::floor(y) + dj;
      const double weight = (1 - std::abs(x - i)) * (1 - std::abs(y - j));
      sum += weight * map.Fraction(static_cast<uint32_t>(std::clamp(i, 0.0, map.width - 1.0)),
                                   static_cast<uint32_t>(std::clamp(j, 0.0, map.height - 1.0)));
    }
  }
  return sum;
}

TEST_F(VisibilityGlslTest, EqualsTheCppAtRandomPoints) {
  const auto artifact = SkewedArtifact();
  ASSERT_NE(artifact, nullptr);
  const auto& texture = std::get<SoftShadowTexture>(artifact->payload);
  std::mt19937 engine(1);
  std::uniform_real_distribution<float> around(-0.25f, 1.25f), off(-0.5f, 0.5f);
  const Vec3 normal = texture.receiver.patch.normal();
  std::vector<Vec4> points;
  for (int i = 0; i < kPoints; ++i) {
    points.emplace_back(
        texture.receiver.patch.At({around(engine), around(engine)}) + off(engine) * normal, 1);
  }
  const std::vector<Vec4> results = Run(texture, points);
  ASSERT_EQ(results.size(), points.size());
  int compared = 0;
  for (int i = 0; i < kPoints; ++i) {
    const Vec2 uv(results[i].x, results[i].y);
    // Projecting in single precision may move a point across a texel's border.
    const Vec2 texel = uv * Vec2(texture.visibility.width, texture.visibility.height);
    const Vec2 to_border = glm::abs(texel - glm::round(texel));
    if (std::min(to_border.x, to_border.y) > 1e-4f) {
      ++compared;
      ASSERT_FLOAT_EQ(results[i].z, Visibility(*artifact, Vec3(points[i]), normal))
          << "at uv " << uv.x << " " << uv.y;
    }
    ASSERT_NEAR(results[i].w, Smooth(texture.visibility, uv), 2e-5)
        << "at uv " << uv.x << " " << uv.y;
  }
  EXPECT_GT(compared, kPoints * 99 / 100);
}

TEST_F(VisibilityGlslTest, TexelCentresGiveTheirCounts) {
  const auto artifact = SkewedArtifact();
  ASSERT_NE(artifact, nullptr);
  const auto& texture = std::get<SoftShadowTexture>(artifact->payload);
  std::vector<Vec4> points(128);
  for (size_t k = 0; k < 91; ++k) {
    points[k] = Vec4(texture.receiver.TexelCenter(k % 13, static_cast<uint32_t>(k / 13)), 1);
  }
  const std::vector<Vec4> results = Run(texture, points);
  ASSERT_EQ(results.size(), points.size());
  for (uint32_t k = 0; k < 91; ++k) {
    EXPECT_NEAR(results[k].w, texture.visibility.Fraction(k % 13, k / 13), 2e-5) << "texel " << k;
  }
}

TEST_F(VisibilityGlslTest, TheMaskIsTheOneOfTheCpp) {
  const auto plain = SkewedArtifact();
  ASSERT_NE(plain, nullptr);
  Artifact artifact = *plain;
  auto& texture = std::get<SoftShadowTexture>(artifact.payload);
  auto mask = std::make_shared<CoverageMask>(13, 7);
  for (size_t k = 0; k < 91; ++k) {
    if (k % 3 == 1 || k % 7 == 2) mask->Set(k);
  }
  texture.coverage = mask;
  std::mt19937 engine(2);
  std::uniform_real_distribution<float> around(0, 1);
  std::vector<Vec4> points;
  for (int i = 0; i < kPoints; ++i) {
    points.emplace_back(texture.receiver.patch.At({around(engine), around(engine)}), 1);
  }
  const std::vector<Vec4> results = Run(texture, points, kCoverageGlsl);
  ASSERT_EQ(results.size(), points.size());
  int inside = 0, outside = 0;
  for (int i = 0; i < kPoints; ++i) {
    const Vec2 texel = Vec2(results[i]) * Vec2(13, 7);
    const Vec2 to_border = glm::abs(texel - glm::round(texel));
    if (std::min(to_border.x, to_border.y) < 1e-4f) continue;
    const bool covers = Covers(artifact, Vec3(points[i]));
    ASSERT_EQ(results[i].z == 3.0f, covers) << "at uv " << results[i].x << " " << results[i].y;
    ++(covers ? inside : outside);
  }
  EXPECT_GT(inside, 1000);
  EXPECT_GT(outside, 1000);
  texture.coverage = nullptr;
  EXPECT_EQ(Run(texture, std::vector<Vec4>(64, Vec4(1, 2, -3, 1)), kCoverageGlsl)[0].z, 3.0f);
}

TEST_F(VisibilityGlslTest, NoSamplesIsAllVisible) {
  SoftShadowTexture texture = std::get<SoftShadowTexture>(SkewedArtifact()->payload);
  texture.visibility.sample_count = 0;
  const std::vector<Vec4> results = Run(texture, std::vector<Vec4>(64, Vec4(1, 2, -3, 1)));
  ASSERT_EQ(results.size(), 64u);
  EXPECT_EQ(results[0].z, 1.0f);
  EXPECT_EQ(results[0].w, 1.0f);
}

}  // namespace
}  // namespace penumbra
