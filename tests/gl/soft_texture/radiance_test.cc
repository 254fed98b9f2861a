// Radiance by GL: equation (3.2) against a sum in double precision over the samples that rays
// reach, and against the integral over the light that it converges to.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "render/reference/light_integral.h"
#include "render/reference/ray_visibility.h"
#include "tests/gl/display/software_context.h"
#include "tests/gl/soft_texture/gl_scenes.h"
#include "tests/support/random_scene.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

constexpr double kPi = std::numbers::pi;

// Written from the paper and the definitions of the lights, not from the shader: what sample `s` of
// n, seen from `x`, adds to the radiance of a white surface.
struct Term {
  const LightSample& s;
  DVec3 x, normal, target;
  bool two_sided;
  double n;
  // What it would be with light straight on and straight out, which rounding is relative to: on the
  // rim of a sphere a small cosine meets a large area.
  bool straight = false;

  double CosTheta(DVec3 omega) const {
    if (straight) return 1;
    const double cosine = glm::dot(normal, omega);
    return two_sided ? std::abs(cosine) : std::max(0.0, cosine);
  }
  DVec3 Surface(DVec3 light_normal, double area, bool both_faces, Vec3 radiance) const {
    const DVec3 d = DVec3(s.point) - x;
    const double r = glm::length(d);
    double cos_light = -glm::dot(light_normal, d) / r;
    cos_light = straight ? 1 : both_faces ? std::abs(cos_light) : std::max(0.0, cos_light);
    return DVec3(radiance) * (area * CosTheta(d / r) * cos_light / (kPi * r * r));
  }

  DVec3 operator()(const RectangleLight& light) const {
    const DVec3 cross = glm::cross(DVec3(light.edge_u), DVec3(light.edge_v));
    return Surface(glm::normalize(cross), glm::length(cross) / n, light.two_sided, light.radiance);
  }
  DVec3 operator()(const DiskLight& light) const {
    return Surface(glm::normalize(DVec3(light.normal)), kPi * light.radius * light.radius / n,
                   light.two_sided, light.radiance);
  }
  // A share of the disc that the target sees, stretched onto the sphere.
  DVec3 operator()(const SphereLight& light) const {
    const DVec3 out = glm::normalize(DVec3(s.point) - DVec3(light.center));
    const DVec3 axis = glm::normalize(target - DVec3(light.center));
    return Surface(out, kPi * light.radius * light.radius / n / glm::dot(out, axis), false,
                   light.radiance);
  }
  DVec3 Point(Vec3 position, Vec3 intensity) const {
    const DVec3 d = DVec3(position) - x;
    const double r = glm::length(d);
    return DVec3(intensity) * (CosTheta(d / r) / (kPi * r * r));
  }
  DVec3 operator()(const PointLight& light) const { return Point(light.position, light.intensity); }
  DVec3 operator()(const SpotLight& light) const {
    const double cosine =
        glm::dot(glm::normalize(x - DVec3(light.position)), glm::normalize(DVec3(light.direction)));
    const double outer = std::cos(double{light.outer_angle}),
                 inner = std::cos(double{light.inner_angle});
    const double ramp = std::clamp((cosine - outer) / (inner - outer), 0.0, 1.0);
    // Rounding of the cosine is magnified by the ramp's slope.
    return (straight ? 1 / (inner - outer) : ramp * ramp) * Point(light.position, light.intensity);
  }
  // E / π cos θ, for a disc in the sky with a sample's share of directions.
  DVec3 operator()(const DistantLight& light) const {
    const DVec3 omega(s.point);
    const double stretch = glm::dot(omega, glm::normalize(DVec3(light.to_light)));
    return DVec3(light.irradiance) * (CosTheta(omega) / (kPi * n * stretch));
  }
};

// The sum at each texel over the samples that rays reach.
struct Sums {
  std::vector<DVec3> radiance, scale;  // scale: what rounding is relative to
  std::vector<int> visible;
};

Sums SumsByRays(const Scene& scene, const Artifact& artifact) {
  const SoftShadowTexture& texture = TextureOf(artifact);
  const ReceiverPatch& receiver = texture.receiver;
  const auto& samples = artifact.header.light_samples;
  const double offset = std::stod(artifact.header.parameters.at("surface_offset_m"));
  const RayVisibility rays(scene, RayVisibility::Intersector::kRobust);
  tbb::task_arena arena(2);
  const size_t texels = texture.visibility.counts.size();
  Sums sums{.radiance = std::vector<DVec3>(texels, DVec3(0.0)),
            .scale = std::vector<DVec3>(texels, DVec3(0.0)),
            .visible = std::vector<int>(texels, 0)};
  for (const LightSample& sample : samples) {
    const VisibilityMap map = rays.Counts(receiver, std::span(&sample, 1), offset, arena);
    for (uint32_t t = 0; t < texels; ++t) {
      Term term{.s = sample,
                .x = DVec3(receiver.TexelCenter(t % receiver.width, t / receiver.width)),
                .normal = DVec3(receiver.patch.normal()),
                .target = DVec3(receiver.patch.At(Vec2(0.5f))),
                .two_sided = receiver.two_sided,
                .n = static_cast<double>(samples.size())};
      const DVec3 reflectance(receiver.reflectance);
      sums.visible[t] += map.counts[t];
      if (map.counts[t]) sums.radiance[t] += std::visit(term, texture.light.shape) * reflectance;
      term.straight = true;
      sums.scale[t] += std::visit(term, texture.light.shape) * reflectance;
    }
  }
  return sums;
}

class GlRadianceTest : public SoftwareContextTest {};

TEST_F(GlRadianceTest, IsTheSumOverTheSamplesThatRaysReach) {
  size_t compared = 0, dark = 0;
  for (uint64_t seed = 0; seed < 48; ++seed) {
    const auto scene = RandomScene(seed);
    const auto by_gl = ComputeOnGl(*context_, *scene, {.samples = 24, .radiance = true});
    ASSERT_TRUE(by_gl.ok()) << by_gl.status();
    const SoftShadowTexture& texture = TextureOf(*by_gl);
    const Sums sums = SumsByRays(*scene, *by_gl);
    for (size_t t = 0; t < sums.visible.size(); ++t) {
      // Otherwise a ray passes within rounding of an edge.
      if (sums.visible[t] != texture.visibility.counts[t]) continue;
      ++compared;
      dark += sums.visible[t] == 0;
      for (int c = 0; c < 3; ++c) {
        ASSERT_NEAR(texture.radiance->texels[t][c], sums.radiance[t][c],
                    3e-6 * sums.scale[t][c] + 1e-12)
            << "scene " << seed << ", texel " << t;
      }
    }
  }
  EXPECT_GT(compared, 100000u);
  EXPECT_GT(dark, 1000u);
}

// With nothing in the way, 1,024 samples come close to the integral: it would show if areas were
// off by any factor.
TEST_F(GlRadianceTest, ConvergesToTheIntegral) {
  for (int kind = 0; kind < kLightKinds; ++kind) {
    for (uint64_t trial = 0; trial < 4; ++trial) {
      Dice dice(3000 + trial);
      const AreaLight light = RandomLight(dice, kind);
      Receiver receiver = FloorReceiver("receiver", 1.5f, 3);
      receiver.two_sided = trial % 2 == 0;
      receiver.reflectance = Vec3(0.9f, 0.5f, 0.2f);
      const auto scene = Scene::Empty("s")
                             ->Apply({.upsert_lights = {light}, .upsert_receivers = {receiver}})
                             .value();
      const auto by_gl = ComputeOnGl(*context_, *scene, {.samples = 1024, .radiance = true});
      ASSERT_TRUE(by_gl.ok()) << by_gl.status();
      const SoftShadowTexture& texture = TextureOf(*by_gl);
      for (uint32_t t = 0; t < 9; ++t) {
        const DVec3 at(texture.receiver.TexelCenter(t % 3, t / 3));
        const DVec3 above = IntegratedRadiance(light, at, DVec3(0, 1, 0));
        const DVec3 below = IntegratedRadiance(light, at, DVec3(0, -1, 0));
        const DVec3 expected =
            (receiver.two_sided ? above + below : above) * DVec3(receiver.reflectance);
        for (int c = 0; c < 3; ++c) {
          EXPECT_NEAR(texture.radiance->texels[t][c], expected[c], 0.02 * expected[c] + 2e-4)
              << "kind " << kind << ", trial " << trial << ", texel " << t;
        }
      }
    }
  }
}

}  // namespace
}  // namespace penumbra::testing
