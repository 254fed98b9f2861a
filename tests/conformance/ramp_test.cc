// Penumbrae whose shape is known in closed form.
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "gtest/gtest.h"
#include "tests/conformance/conformance.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

constexpr uint32_t kTexels = 64;
constexpr uint32_t kSamples = 1024;

class RampTest : public ConformanceTest {
 protected:
  // A sheet at half the light's height fills x < 0, further than any ray goes. A texel at x sees
  // the part of the light beyond −x: `visible_beyond` gives that part.
  void ExpectRamp(const LightShape& light, const std::function<float(float)>& visible_beyond) {
    // Of plausible shadows all of the ramp lies within the outline, half a penumbra from the
    // light's; how wide it is, tests/unit/shadow_width/penumbra_width_test.cc says.
    if (is_plausible()) GTEST_SKIP() << "plausible shadows have ramps of their own";
    const auto grid = Visibilities({.light = light,
                                    .receiver = FloorReceiver("receiver", 2, kTexels),
                                    .occluders = {SheetOver(Vec3(-5, 1, 0), Vec3(5, 1, 5))}},
                                   kSamples);
    double error_sum = 0;
    // Where a surface ends in half shadow, its last pixel in a light's image is taken for hidden.
    const uint32_t border = target() == SpecTarget::kScene ? 4 : 0;
    for (uint32_t j = border; j < kTexels - border; ++j) {
      for (uint32_t i = 0; i < kTexels; ++i) {
        const float x = -1 + 2 * (i + 0.5f) / kTexels;
        const float error = grid[kTexels * j + i] - visible_beyond(-x);
        // An edge along the grid's columns cuts one of 32 of them.
        EXPECT_LE(std::abs(error), 1.5f / 32) << "texel " << i << ", " << j;
        error_sum += error;
      }
    }
    // An edge may lie half a pixel off in all images of a light alike.
    const double most = target() == SpecTarget::kScene ? 0.02 : 0.002;
    EXPECT_LT(std::abs(error_sum) / (kTexels * kTexels), most);
  }
};

TEST_P(RampTest, ARectangleGivesALinearRamp) {
  ExpectRamp(
      RectangleLight{
          .corner = Vec3(-0.4f, 2, -0.3f), .edge_u = Vec3(1.2f, 0, 0), .edge_v = Vec3(0, 0, 0.5f)},
      [](float x) { return std::clamp((0.8f - x) / 1.2f, 0.0f, 1.0f); });
}

TEST_P(RampTest, ADiskGivesCircularSegments) {
  constexpr float kRadius = 0.7f, kCenter = 0.1f;
  ExpectRamp(DiskLight{.center = Vec3(kCenter, 2, 0), .normal = Vec3(0, -1, 0), .radius = kRadius},
             [](float x) {
               const float t = std::clamp((x - kCenter) / kRadius, -1.0f, 1.0f);
               return (std::acos(t) - t * std::sqrt(1 - t * t)) / std::numbers::pi_v<float>;
             });
}

// The sheet's edge is 1 m up, so a texel at x sees directions steeper than −x towards it.
TEST_P(RampTest, ADistantDiscGivesCircularSegments) {
  const float sine = std::sin(0.5f);
  ExpectRamp(DistantLight{.to_light = Vec3(0, 1, 0), .angular_diameter = 1.0f}, [=](float x) {
    // Rays of direction d pass beyond the edge if d.x / d.y > x: a plane through the texel, which
    // cuts the disc of directions, seen from above, along the ellipse d.x² (1 + x²) = x² (1 −
    // d.z²).
    constexpr int kSteps = 2000;
    double inside = 0;
    for (int k = 0; k < kSteps; ++k) {
      const double z = sine * (-1 + 2 * (k + 0.5) / kSteps);
      const double half = std::sqrt(sine * sine - z * z);
      const double edge = std::copysign(std::sqrt(x * x * (1 - z * z) / (1 + x * x)), x);
      inside += std::clamp(half - edge, 0.0, 2 * half) * (2 * sine / kSteps);
    }
    return static_cast<float>(inside / (std::numbers::pi * sine * sine));
  });
}

PENUMBRA_INSTANTIATE_CONFORMANCE(RampTest);

}  // namespace
}  // namespace penumbra::testing
