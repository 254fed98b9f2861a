// Penumbras behind straight edges are as wide as those of the light, without a constant to set.
#include <gtest/gtest.h>

#include <numbers>

#include "render/technique/shadow_width/shadow_width.h"
#include "tests/support/straight_edge.h"

namespace penumbra::testing {
namespace {

Artifact Compute(const StraightEdge& edge) {
  tbb::task_arena arena(2);
  return ShadowWidth()
      .Compute(*edge.MakeScene(), {ShadowWidthParams{.resolution = 768}, edge.light.id},
               {.arena = arena})
      .value();
}

void ExpectWidthsOf(const LightShape& shape) {
  for (const double height : {0.5, 1.25, 2.5}) {
    for (const double angle : {0.0, 0.25 * std::numbers::pi, 0.5 * std::numbers::pi}) {
      const StraightEdge edge{
          .light = {.id = "light", .shape = shape}, .height = height, .angle = angle};
      const auto found = PenumbraWidth(edge, Compute(edge));
      ASSERT_TRUE(found) << "height " << height << ", angle " << angle;
      EXPECT_NEAR(*found / TruePenumbraWidth(edge), 1, 0.2)
          << "height " << height << ", angle " << angle;
    }
  }
}

TEST(PenumbraWidthTest, OfARectangle) {
  ExpectWidthsOf(
      RectangleLight{.corner = {-0.3f, 4, -0.15f}, .edge_u = {0.6f, 0, 0}, .edge_v = {0, 0, 0.3f}});
}
TEST(PenumbraWidthTest, OfADisk) {
  ExpectWidthsOf(DiskLight{.center = {0, 4, 0}, .normal = {0, -1, 0}, .radius = 0.3f});
}
TEST(PenumbraWidthTest, OfATiltedDisk) {
  ExpectWidthsOf(DiskLight{.center = {0.5f, 4, 0}, .normal = {-0.3f, -1, 0.2f}, .radius = 0.3f});
}
TEST(PenumbraWidthTest, OfASphere) {
  ExpectWidthsOf(SphereLight{.center = {0.3f, 4, 0.2f}, .radius = 0.25f});
}
TEST(PenumbraWidthTest, OfTheSun) {
  ExpectWidthsOf(DistantLight{.to_light = {0.1f, 1, 0.05f}, .angular_diameter = 0.15f});
}

// Of a light without a size a shadow is as sharp as the map's texels.
TEST(PenumbraWidthTest, OfAPointIsATexel) {
  const StraightEdge edge{.light = {.id = "light", .shape = PointLight{.position = {0, 4, 0}}}};
  const auto found = PenumbraWidth(edge, Compute(edge));
  ASSERT_TRUE(found);
  EXPECT_LT(*found, 0.05);
}

}  // namespace
}  // namespace penumbra::testing
