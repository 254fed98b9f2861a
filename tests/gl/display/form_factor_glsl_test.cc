// The GLSL closed forms against the C++ ones, light by light, at thousands of random places.
#include "client/display/form_factor_glsl.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

#include "absl/strings/str_cat.h"
#include "render/gl/buffer.h"
#include "render/gl/draw.h"
#include "render/gl/program.h"
#include "render/scene/unoccluded_light.h"
#include "tests/gl/display/software_context.h"

namespace penumbra {
namespace {

struct Place {
  Vec4 point;
  Vec4 normal;
};

struct Case {
  AreaLight light;
  Vec3 point;
  Vec3 normal;
};

constexpr int kCases = 4096;
constexpr int kGroup = 64;

constexpr char kComputeGlsl[] = R"(
layout(local_size_x = 64) in;
struct Place { vec4 point; vec4 normal; };
layout(std430, binding = 0) readonly buffer Lights { Light lights[]; };
layout(std430, binding = 1) readonly buffer Places { Place places[]; };
layout(std430, binding = 2) buffer Results { vec4 results[]; };
void main() {
  uint i = gl_GlobalInvocationID.x;
  results[i] = vec4(UnoccludedRadiance(lights[i], places[i].point.xyz, places[i].normal.xyz), 1.0);
})";

class Draw {
 public:
  explicit Draw(uint32_t seed) : engine_(seed) {}
  float In(float low, float high) {
    return std::uniform_real_distribution<float>(low, high)(engine_);
  }
  Vec3 Box(float side) { return {In(-side, side), In(-side, side), In(-side, side)}; }
  Vec3 Direction() {
    std::normal_distribution<float> normal;
    return glm::normalize(Vec3(normal(engine_), normal(engine_), normal(engine_)));
  }
  // Log-uniform, so that near and far, large and small come alike.
  float Size(float low, float high) { return std::exp(In(std::log(low), std::log(high))); }

 private:
  std::mt19937 engine_;
};

class FormFactorGlslTest : public SoftwareContextTest {
 protected:
  std::vector<Vec3> Run(const std::vector<Case>& cases) {
    std::vector<GpuLight> lights;
    std::vector<Place> places;
    for (const Case& c : cases) {
      lights.push_back(ToGpu(c.light));
      places.push_back({Vec4(c.point, 0), Vec4(c.normal, 0)});
    }
    std::vector<Vec4> results(cases.size());
    auto program =
        gl::Program::Create(*context_, {.compute = absl::StrCat(FormFactorGlsl(), kComputeGlsl)});
    EXPECT_TRUE(program.ok()) << program.status();
    auto light_buffer = gl::Buffer::Create(*context_, std::as_bytes(std::span(lights)));
    auto place_buffer = gl::Buffer::Create(*context_, std::as_bytes(std::span(places)));
    auto result_buffer = gl::Buffer::Create(*context_, results.size() * sizeof(Vec4));
    if (!program.ok() || !light_buffer.ok() || !place_buffer.ok() || !result_buffer.ok()) return {};
    light_buffer->BindStorage(*context_, 0);
    place_buffer->BindStorage(*context_, 1);
    result_buffer->BindStorage(*context_, 2);
    gl::Dispatch(*context_, *program, static_cast<uint32_t>(cases.size() / kGroup));
    EXPECT_TRUE(result_buffer->Read(*context_, 0, std::as_writable_bytes(std::span(results))).ok());
    return {results.begin(), results.end()};
  }

  // `scale`: what the light gives at most at a place, to which the tolerance is relative.
  void Compare(const std::function<Case(Draw&)>& make,
               const std::function<double(const Case&)>& scale, double tolerance) {
    Draw draw(20240517);
    std::vector<Case> cases;
    for (int i = 0; i < kCases; ++i) cases.push_back(make(draw));
    const std::vector<Vec3> results = Run(cases);
    ASSERT_EQ(results.size(), cases.size());
    double worst = 0;
    int worst_case = 0, lit = 0;
    for (int i = 0; i < kCases; ++i) {
      const Case& c = cases[i];
      const Vec3 expected = UnoccludedRadiance(c.light, c.point, c.normal);
      lit += expected.x > 0;
      const double error = std::abs(double{results[i].x} - expected.x) / scale(c);
      if (!(error <= worst)) worst = error, worst_case = i;
    }
    RecordProperty("worst_relative_error", absl::StrCat(worst));
    RecordProperty("lit", lit);
    EXPECT_GT(lit, kCases / 4) << "too few cases say anything";
    const Case& c = cases[worst_case];
    EXPECT_LE(worst, tolerance) << "at point " << c.point.x << " " << c.point.y << " " << c.point.z
                                << ", normal " << c.normal.x << " " << c.normal.y << " "
                                << c.normal.z << ": GLSL " << results[worst_case].x << ", C++ "
                                << UnoccludedRadiance(c.light, c.point, c.normal).x;
  }
};

// Facing the centre of the light and alone with it: the share of the hemisphere that it can fill at
// most.
double SolidShare(double radius, double distance) {
  const double ratio = radius / std::max(radius, distance);
  return ratio * ratio;
}

// Tolerances: single precision rounds to 6e-8. An edge of an outline as far away as 200 times its
// length adds two terms that cancel but for one part in 200, which leaves 1e-5; tests of roundness
// go no further.
constexpr double kOutlineTolerance = 5e-5;
constexpr double kRoundTolerance = 2e-5;

TEST_F(FormFactorGlslTest, Rectangle) {
  Compare(
      [](Draw& draw) {
        RectangleLight light;
        const float size = draw.Size(0.05f, 5.0f);
        light.corner = draw.Box(2.0f);
        light.edge_u = size * draw.Direction();
        light.edge_v = draw.Size(0.2f, 5.0f) * size * draw.Direction();
        light.two_sided = draw.In(0, 1) < 0.5f;
        return Case{{.id = "l", .shape = light}, draw.Box(3.0f), draw.Direction()};
      },
      [](const Case& c) {
        const auto& light = std::get<RectangleLight>(c.light.shape);
        const double area = glm::length(glm::cross(light.edge_u, light.edge_v));
        const Vec3 center = light.corner + 0.5f * (light.edge_u + light.edge_v);
        return std::min(1.0, area / std::pow(glm::length(center - c.point), 2)) + 1e-3;
      },
      kOutlineTolerance);
}

TEST_F(FormFactorGlslTest, RectangleFarAway) {
  Compare(
      [](Draw& draw) {
        const RectangleLight light = {
            .corner = {0, 0, 0}, .edge_u = {0.3f, 0.1f, 0}, .edge_v = {0, 0.1f, 0.4f}};
        const Vec3 direction = draw.Direction();
        Vec3 n = draw.Direction();
        if (glm::dot(n, direction) > 0) n = -n;
        return Case{{.id = "l", .shape = light}, draw.Size(5, 60) * direction, n};
      },
      [](const Case& c) { return 0.12 / (std::numbers::pi * glm::dot(c.point, c.point)); },
      kOutlineTolerance);
}

TEST_F(FormFactorGlslTest, Disk) {
  Compare(
      [](Draw& draw) {
        DiskLight light;
        light.center = draw.Box(2.0f);
        light.normal = 3.0f * draw.Direction();
        light.radius = draw.Size(0.05f, 3.0f);
        light.two_sided = draw.In(0, 1) < 0.5f;
        return Case{{.id = "l", .shape = light}, draw.Box(4.0f), draw.Direction()};
      },
      [](const Case& c) {
        const auto& light = std::get<DiskLight>(c.light.shape);
        return SolidShare(light.radius, glm::length(light.center - c.point)) + 1e-3;
      },
      kOutlineTolerance);
}

TEST_F(FormFactorGlslTest, DiskFarAway) {
  Compare(
      [](Draw& draw) {
        const DiskLight light = {.center = {0, 0, 0}, .normal = {0, 1, 0}, .radius = 0.1f};
        const Vec3 direction = draw.Direction();
        Vec3 n = draw.Direction();
        if (glm::dot(n, direction) > 0) n = -n;
        return Case{{.id = "l", .shape = light}, draw.Size(2, 60) * direction, n};
      },
      [](const Case& c) { return 0.01 / glm::dot(c.point, c.point); }, kOutlineTolerance);
}

TEST_F(FormFactorGlslTest, SphereAlsoFromInside) {
  Compare(
      [](Draw& draw) {
        const SphereLight light = {.center = draw.Box(2.0f), .radius = draw.Size(0.01f, 3.0f)};
        return Case{{.id = "l", .shape = light}, draw.Box(4.0f), draw.Direction()};
      },
      [](const Case& c) {
        const auto& light = std::get<SphereLight>(c.light.shape);
        return SolidShare(light.radius, glm::length(light.center - c.point));
      },
      kRoundTolerance);
}

TEST_F(FormFactorGlslTest, Point) {
  Compare(
      [](Draw& draw) {
        return Case{{.id = "l", .shape = PointLight{.position = draw.Box(2.0f)}},
                    draw.Box(4.0f),
                    draw.Direction()};
      },
      [](const Case& c) {
        const Vec3 d = std::get<PointLight>(c.light.shape).position - c.point;
        return 1 / (std::numbers::pi * glm::dot(d, d));
      },
      kRoundTolerance);
}

TEST_F(FormFactorGlslTest, Spot) {
  Compare(
      [](Draw& draw) {
        SpotLight light;
        light.position = draw.Box(2.0f);
        light.outer_angle = draw.In(0.5f, 1.5f);
        light.inner_angle = draw.In(0.0f, 0.8f) * light.outer_angle;
        const Vec3 point = draw.Box(4.0f);
        const Vec3 ray = glm::normalize(point - light.position);
        light.direction = 7.0f * (ray + 0.8f * draw.Direction());
        const Vec3 n = draw.Direction();
        return Case{{.id = "l", .shape = light}, point, glm::dot(n, ray) < 0 ? n : -n};
      },
      [](const Case& c) {
        const Vec3 d = std::get<SpotLight>(c.light.shape).position - c.point;
        return 1 / (std::numbers::pi * glm::dot(d, d));
      },
      kRoundTolerance);
}

TEST_F(FormFactorGlslTest, DistantFromPointToWideDisc) {
  Compare(
      [](Draw& draw) {
        DistantLight light;
        light.to_light = 5.0f * draw.Direction();
        light.angular_diameter = draw.In(0, 1) < 0.2f ? 0.0f : draw.Size(0.002f, 1.57f);
        return Case{{.id = "l", .shape = light}, draw.Box(4.0f), draw.Direction()};
      },
      [](const Case&) { return 1 / std::numbers::pi; }, kRoundTolerance);
}

// The horizon cuts the disc of the sun in each of these, where the closed form's terms cancel most.
TEST_F(FormFactorGlslTest, SunOnTheHorizon) {
  constexpr float kDiameter = 0.00925f;
  Compare(
      [](Draw& draw) {
        const Vec3 to_light = draw.Direction();
        const Vec3 across = glm::normalize(glm::cross(to_light, draw.Direction()));
        const float elevation = draw.In(-0.5f, 0.5f) * kDiameter;
        const Vec3 n = std::cos(elevation) * across + std::sin(elevation) * to_light;
        const DistantLight light = {.to_light = to_light, .angular_diameter = kDiameter};
        return Case{{.id = "l", .shape = light}, Vec3(0), glm::normalize(n)};
      },
      // A disc cut in half on the horizon gives 2/3π of its half-angle.
      [](const Case&) { return 0.5 * kDiameter * 2 / (3 * std::numbers::pi) / std::numbers::pi; },
      1e-3);
}

TEST_F(FormFactorGlslTest, ColourChannelsStayApart) {
  const AreaLight light = {
      .id = "l", .shape = SphereLight{.center = {0, 2, 0}, .radius = 1, .radiance = {4, 8, 16}}};
  const std::vector<Case> cases(kGroup, Case{light, Vec3(0), Vec3(0, 1, 0)});
  const std::vector<Vec3> results = Run(cases);
  ASSERT_EQ(results.size(), cases.size());
  // Half the distance is the radius, so the sphere fills sin² 30° of the hemisphere.
  EXPECT_NEAR(results[0].x, 1, 1e-5);
  EXPECT_NEAR(results[0].y, 2, 2e-5);
  EXPECT_NEAR(results[0].z, 4, 4e-5);
}

// Such as a lamp's own plate, from its front and from behind.
TEST_F(FormFactorGlslTest, NothingComesFromALightToWhatItLiesOn) {
  Draw draw(7);
  std::vector<Case> cases;
  for (int i = 0; i < kCases; ++i) {
    const Vec3 at = draw.Box(10), u = draw.Direction();
    const Vec3 v = glm::normalize(glm::cross(u, draw.Direction())), n = glm::cross(u, v);
    const bool both = i % 2 == 0;
    AreaLight lamp{.shape = RectangleLight{at, 2.0f * u, 2.0f * v, Vec3(1.0f), both}};
    if (i % 4 < 2) lamp.shape = DiskLight{at, n, 2, Vec3(1.0f), both};
    const Vec3 point = at + draw.In(-1, 2) * u + draw.In(-1, 2) * v;
    cases.push_back({.light = lamp, .point = point, .normal = i % 8 < 4 ? n : -n});
  }
  for (const Vec3& radiance : Run(cases)) ASSERT_EQ(radiance, Vec3(0.0f));
}

}  // namespace
}  // namespace penumbra
