#include "render/technique/soft_texture/careful_triangle.h"

#include <gtest/gtest.h>

#include <random>

namespace penumbra {
namespace {

double Area(const ClippedPolygon& polygon) {
  double twice = 0;
  for (size_t i = 0; i < polygon.size; ++i) {
    const DVec2 a = polygon.texels[i], b = polygon.texels[(i + 1) % polygon.size];
    twice += a.x * b.y - a.y * b.x;
  }
  return std::abs(twice) / 2;
}

TEST(ClipToTexture, KeepsWhatIsInside) {
  // A right triangle of legs 1/2 at w = 1/2: its shadow has legs of 1, that is of 100 and 40
  // texels.
  const HomogeneousTriangle triangle = {DVec3(0, 0, 0.5), DVec3(0.5, 0, 0.5), DVec3(0, 0.5, 0.5)};
  const ClippedPolygon polygon = ClipToTexture(triangle, 100, 40);
  ASSERT_EQ(polygon.size, 3u);
  EXPECT_DOUBLE_EQ(Area(polygon), 100 * 40 / 2.0);
  EXPECT_DOUBLE_EQ(polygon.texels[0].x, -0.5);
}

TEST(ClipToTexture, CutsALargeTriangleToTheMargin) {
  const HomogeneousTriangle triangle = {DVec3(-100, -100, 1), DVec3(300, -100, 1),
                                        DVec3(-100, 300, 1)};
  // [−½, 1½]² of a texture of 10 by 10.
  EXPECT_NEAR(Area(ClipToTexture(triangle, 10, 10)), 20 * 20, 1e-9);
}

TEST(ClipToTexture, DropsWhatIsBehindTheLight) {
  const HomogeneousTriangle behind = {DVec3(0, 0, -0.5), DVec3(-1, 0, -0.5), DVec3(0, -1, -0.5)};
  EXPECT_EQ(ClipToTexture(behind, 10, 10).size, 0u);
  // One corner passes the light: the shadow goes on to infinity, here to the margin, and never
  // flips over.
  const HomogeneousTriangle through = {DVec3(0.2, 0.2, 1), DVec3(0.8, 0.2, 1), DVec3(0.5, 5, -0.5)};
  const ClippedPolygon polygon = ClipToTexture(through, 10, 10);
  ASSERT_GE(polygon.size, 3u);
  for (size_t i = 0; i < polygon.size; ++i) {
    EXPECT_GT(polygon.texels[i].y, 10 * 0.2 - 0.5 - 1e-9);
  }
}

TEST(UvAcrossTriangle, MeetsTheTriangleWhereTheRayDoes) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0.05, 0.95);
  for (int trial = 0; trial < 100; ++trial) {
    HomogeneousTriangle triangle;
    for (DVec3& p : triangle) p = {uniform(random), uniform(random), uniform(random)};
    const std::array<Vec2, 3> uv = {Vec2(0, 0), Vec2(1, 0), Vec2(0, 1)};
    const uint32_t column = random() % 64, row = random() % 32;
    // Σ b_k P_k = τ (u, v, 1) with Σ b_k = 1.
    const DVec3 ray((column + 0.5) / 64, (row + 0.5) / 32, 1);
    const glm::dmat3 corners(triangle[0], triangle[1], triangle[2]);
    if (std::abs(glm::determinant(corners)) < 1e-3) continue;
    DVec3 b = glm::inverse(corners) * ray;
    const double sum = b.x + b.y + b.z;
    if (std::abs(sum) < 1e-2) continue;
    b /= sum;
    const Vec2 found = UvAcrossTriangle(triangle, uv, 64, 32).At(column, row);
    EXPECT_NEAR(found.x, b.y, 1e-4 * (1 + std::abs(b.y)));
    EXPECT_NEAR(found.y, b.z, 1e-4 * (1 + std::abs(b.z)));
  }
}

}  // namespace
}  // namespace penumbra
