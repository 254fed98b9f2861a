#include "render/scene/camera.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "client/display/picture_tile.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

using ::testing::HasSubstr;

DVec3 Project(const DMat4& clip_from_world, Vec3 p) {
  const DVec4 clip = clip_from_world * DVec4(DVec3(p), 1);
  return DVec3(clip) / clip.w;
}

TEST(CameraTest, ProjectsKnownPoints) {
  // 90° from 2 away: what is 2 beside the target lies on the picture's edge.
  const Camera camera = {.eye = {1, 2, 5}, .target = {1, 2, 3}, .up = {0, 1, 0}, .fov_y_deg = 90};
  const DMat4 clip = ClipFromWorld(camera, 2.0);
  const DVec3 center = Project(clip, {1, 2, 3});
  EXPECT_NEAR(center.x, 0, 1e-12);
  EXPECT_NEAR(center.y, 0, 1e-12);
  const DVec3 corner = Project(clip, {5, 4, 3});  // right and up
  EXPECT_NEAR(corner.x, 1, 1e-12);
  EXPECT_NEAR(corner.y, 1, 1e-12);
  EXPECT_GT(center.z, Project(clip, {1, 2, 2}).z) << "nearer is larger";
  EXPECT_GT(Project(clip, {1, 2, -1e9f}).z, 0) << "nothing is too far";
  EXPECT_LE(center.z, 1);
}

TEST(CameraTest, LooksStraightDown) {
  const Camera camera = {.eye = {0, 5, 0}, .target = {0, 0, 0}, .up = {0, 1, 0}, .fov_y_deg = 90};
  const DVec3 p = Project(ClipFromWorld(camera, 1), {0, 0, -2.5f});
  EXPECT_TRUE(std::isfinite(p.x) && std::isfinite(p.y));
  EXPECT_NEAR(std::hypot(p.x, p.y), 0.5, 1e-9);
}

TEST(CameraTest, FramesAllCornersAndWastesLittle) {
  const Aabb boxes[] = {{.min = {-1, 0, -1}, .max = {1, 2, 1}},
                        {.min = {10, -3, 4}, .max = {40, -2.9f, 6}},
                        {.min = {0, 0, 0}, .max = {0.01f, 30, 0.01f}},
                        {.min = {5, 5, 5}, .max = {5, 5, 5}}};
  for (const Aabb& box : boxes) {
    for (const float aspect : {0.5f, 1.0f, 2.5f}) {
      const Camera camera = FrameScene(box, aspect);
      ASSERT_TRUE(CheckCamera(camera).ok());
      const DMat4 clip = ClipFromWorld(camera, aspect);
      double largest = 0;
      for (int corner = 0; corner < 8; ++corner) {
        const Vec3 p((corner & 1) ? box.max.x : box.min.x, (corner & 2) ? box.max.y : box.min.y,
                     (corner & 4) ? box.max.z : box.min.z);
        const DVec3 at = Project(clip, p);
        EXPECT_GT(at.z, 0) << "in front of the eye";
        largest = std::max({largest, std::abs(at.x), std::abs(at.y)});
      }
      EXPECT_LE(largest, 1);
      if (box.extent() != Vec3(0)) {
        EXPECT_GT(largest, 0.9);
      }
      EXPECT_GT(camera.eye.y, camera.target.y) << "from above";
    }
  }
}

TEST(CameraTest, FramesNothingToo) { EXPECT_TRUE(CheckCamera(FrameScene(Aabb{}, 1.5f)).ok()); }

TEST(CameraTest, RefusesWhatShowsNothing) {
  const Camera good;
  EXPECT_TRUE(CheckCamera(good).ok());
  Camera camera = good;
  camera.eye.x = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(std::string(CheckCamera(camera).message()), HasSubstr("camera.eye"));
  camera.eye.x = 1e30f;
  EXPECT_EQ(ErrorFieldPath(CheckCamera(camera)), "camera.eye");
  EXPECT_THAT(std::string(CheckCamera(camera).message()), HasSubstr("found (1e+30, "));
  camera.eye.x = -1e9f;
  EXPECT_TRUE(CheckCamera(camera).ok());
  EXPECT_EQ(ErrorReason(CheckCamera(camera, {.max_coordinate = 1e8f})), "OUT_OF_BOUNDS");
  camera = good;
  camera.target.z = -2e9f;
  EXPECT_EQ(ErrorFieldPath(CheckCamera(camera)), "camera.target");
  EXPECT_EQ(ErrorReason(CheckCamera(camera)), "OUT_OF_BOUNDS");
  camera = good;
  camera.up = Vec3(0);
  EXPECT_THAT(std::string(CheckCamera(camera).message()), HasSubstr("camera.up"));
  for (const float fov : {0.0f, 180.0f, -3.0f, std::numeric_limits<float>::quiet_NaN()}) {
    camera = good;
    camera.fov_y_deg = fov;
    EXPECT_EQ(CheckCamera(camera).code(), absl::StatusCode::kInvalidArgument) << fov;
    EXPECT_THAT(std::string(CheckCamera(camera).message()), HasSubstr("camera.fov_y_deg: found"));
  }
}

TEST(PictureTileTest, TilesCoverThePictureOnce) {
  const PictureTile tile = {.x = 100, .y = 40, .width = 50, .height = 30, .side = 64};
  const DMat4 m = TileFromClip(tile, 200, 120);
  // Picture x of 100 is clip 0; y of 40 from the top is clip 1/3.
  const DVec4 corner = m * DVec4(0, 1.0 / 3, 0.5, 1);
  EXPECT_NEAR(corner.x, -1, 1e-12);
  EXPECT_NEAR(corner.y, 1, 1e-12);
  const DVec4 far_corner = m * DVec4(2.0 * 164 / 200 - 1, 1 - 2.0 * 104 / 120, 0.5, 1);
  EXPECT_NEAR(far_corner.x, 1, 1e-12);
  EXPECT_NEAR(far_corner.y, -1, 1e-12);
}

TEST(PictureTileTest, ResolvesFromTheBottomUp) {
  const PictureTile tile = {.x = 1, .y = 0, .width = 1, .height = 2, .side = 2};
  Picture picture = {.width = 2, .height = 2, .pixels = std::vector<Vec4>(4, Vec4(-1))};
  std::vector<Vec4> samples;  // 4 × 4, the row below first
  for (int i = 0; i < 16; ++i) samples.emplace_back(static_cast<float>(i));
  ResolveTile(samples, 2, tile, picture);
  EXPECT_EQ(picture.At(1, 0), Vec4((12 + 13 + 8 + 9) / 4.0f));
  EXPECT_EQ(picture.At(1, 1), Vec4((0 + 1 + 4 + 5) / 4.0f));
  EXPECT_EQ(picture.At(0, 0), Vec4(-1));
}

}  // namespace
}  // namespace penumbra
