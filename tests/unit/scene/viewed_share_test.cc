#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "render/scene/camera.h"

namespace penumbra {
namespace {

// A patch of width a and height b, square to the view at distance d, fills
// a b / (4 d² tan²(fov / 2) aspect) of the picture.
TEST(ViewedShareTest, OfAPatchSquareToTheView) {
  const View view{.camera = {.eye = Vec3(1, 2, 10), .target = Vec3(1, 2, 0), .fov_y_deg = 60},
                  .aspect = 2};
  const double whole = 4 * 36 * std::pow(std::tan(std::numbers::pi / 6), 2) * 2;
  const auto patch = [](Vec3 origin, float a, float b) {
    return Parallelogram{.origin = origin, .edge_u = Vec3(a, 0, 0), .edge_v = Vec3(0, b, 0)};
  };
  EXPECT_NEAR(ViewedShare(view, patch(Vec3(0, 1, 4), 2, 1)), 2 / whole, 1e-7);
  EXPECT_NEAR(ViewedShare(view, patch(Vec3(2, 1, 4), -2, 1)), 2 / whole, 1e-7) << "its back";
  EXPECT_EQ(ViewedShare(view, patch(Vec3(0, 1, 14), 2, 1)), 0) << "behind the eye";
  EXPECT_NEAR(ViewedShare(view, patch(Vec3(-500, -500, 4), 1000, 1000)), 1, 1e-6);
  EXPECT_NEAR(ViewedShare(view, patch(Vec3(1, -500, 4), 1000, 1000)), 0.5, 1e-6)
      << "the right half";
}

// Sheared, tilted, and through the plane of the eye, against counting rays of the picture.
TEST(ViewedShareTest, AgreesWithCountingPixels) {
  const View view{.camera = {.eye = Vec3(0, 1, 3), .target = Vec3(0.2f, 0, 0)}, .aspect = 1.5};
  const DMat4 world_from_clip = glm::inverse(ClipFromWorld(view.camera, view.aspect));
  for (const Parallelogram& patch :
       {Parallelogram{
            .origin = Vec3(-1, 0, 1), .edge_u = Vec3(2, 0.3f, 0), .edge_v = Vec3(1, 0, -2)},
        Parallelogram{
            .origin = Vec3(-5, 0, 9), .edge_u = Vec3(4, 0, 0), .edge_v = Vec3(3, 0, -18)}}) {
    int inside = 0;
    constexpr int kSide = 400;
    const DVec3 eye(view.camera.eye);
    for (int i = 0; i < kSide * kSide; ++i) {
      const DVec4 far = world_from_clip * DVec4((i % kSide + 0.5) * 2 / kSide - 1,
                                                (i / kSide + 0.5) * 2 / kSide - 1, 1e-3, 1);
      const DVec3 ray = DVec3(far) / far.w - eye;
      const glm::dmat3 lines(DVec3(patch.edge_u), DVec3(patch.edge_v), -ray);
      const DVec3 uvt = glm::inverse(lines) * (eye - DVec3(patch.origin));
      inside += uvt.x >= 0 && uvt.x <= 1 && uvt.y >= 0 && uvt.y <= 1 && uvt.z > 0;
    }
    EXPECT_GT(inside, 1000);
    EXPECT_NEAR(ViewedShare(view, patch), inside / (1.0 * kSide * kSide), 2e-3);
  }
}

}  // namespace
}  // namespace penumbra
