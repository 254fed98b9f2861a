#include "render/scene/point_receiver.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "render/scene/field_error.h"

namespace penumbra {
namespace {

using ::testing::HasSubstr;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

PicturePixels Picture() { return {.camera = {}, .width = 640, .height = 480}; }

GivenPoints Given(std::vector<SurfacePoint> points) {
  return {std::make_shared<const std::vector<SurfacePoint>>(std::move(points))};
}

// What is wrong with it: "field REASON".
std::string Fault(const PointReceiver& receiver, const SceneLimits& limits = {}) {
  const absl::Status status = Check(receiver, limits);
  if (status.ok()) return "";
  EXPECT_THAT(std::string(status.message()), HasSubstr("need"));
  return ErrorFieldPath(status) + " " + ErrorReason(status);
}

TEST(PointReceiver, GridIsThatOfThePart) {
  PicturePixels picture = Picture();
  EXPECT_EQ(GridOf(picture).width, 640u);
  EXPECT_EQ(GridOf(picture).height, 480u);
  picture.crop = {.x = 600, .y = 2, .width = 40, .height = 30};
  EXPECT_EQ(GridOf(picture).width, 40u);
  EXPECT_EQ(GridOf(picture).height, 30u);
  EXPECT_EQ(GridOf(LightmapTexels{"a", 3, 4}).height, 4u);
  EXPECT_EQ(GridOf(Given({{}, {}})).width, 2u);
  EXPECT_EQ(GridOf(Given({{}, {}})).height, 1u);
  EXPECT_EQ(GridOf(GivenPoints{}).width, 0u);
}

TEST(PointReceiver, PicturesThatCannotBeAreNamed) {
  EXPECT_EQ(Fault(Picture()), "");
  PicturePixels picture = Picture();
  picture.camera.eye.x = kNan;
  EXPECT_EQ(Fault(picture), "picture.camera.eye NON_FINITE");
  picture.camera.eye.x = 1e30f;
  EXPECT_EQ(Fault(picture), "picture.camera.eye OUT_OF_BOUNDS");
  picture = Picture();
  picture.camera.target.y = 11;
  EXPECT_EQ(Fault(picture, {.max_coordinate = 10}), "picture.camera.target OUT_OF_BOUNDS");
  picture = Picture();
  picture.width = 0;
  EXPECT_EQ(Fault(picture), "picture.width RANGE");
  picture = Picture();
  picture.height = 20'000;
  EXPECT_EQ(Fault(picture), "picture.height RANGE");
  // A deep zoom into the same picture can be.
  picture.crop = {.x = 639, .y = 19'999, .width = 1, .height = 1};
  EXPECT_EQ(Fault(picture), "");
  picture.crop.y = 20'000;
  EXPECT_EQ(Fault(picture), "picture.crop RANGE");
  picture.crop = {.x = 0xffffffff, .y = 0, .width = 2, .height = 1};
  EXPECT_EQ(Fault(picture), "picture.crop RANGE");
  picture.crop = {.x = 1, .y = 0, .width = 0, .height = 1};
  EXPECT_EQ(Fault(picture), "picture.crop RANGE");
  picture.crop = {.x = 10, .y = 10, .width = 20, .height = 20};
  picture.first = {.x = 10, .y = 10, .width = 21, .height = 1};
  EXPECT_EQ(Fault(picture), "picture.first RANGE");
  picture.first.width = 20;
  EXPECT_EQ(Fault(picture), "");
  EXPECT_EQ(Fault(Picture(), {.max_receiver_texels = 640 * 479}), "picture QUOTA_TEXELS");
}

TEST(PointReceiver, LightmapsThatCannotBeAreNamed) {
  EXPECT_EQ(Fault(LightmapTexels{"a", 3, 4}), "");
  EXPECT_EQ(Fault(LightmapTexels{"", 3, 4}), "lightmap.instance_id BAD_ID");
  EXPECT_EQ(Fault(LightmapTexels{"a", 0, 4}), "lightmap.width RANGE");
  EXPECT_EQ(Fault(LightmapTexels{"a", 3, 16'385}), "lightmap.height RANGE");
  EXPECT_EQ(Fault(LightmapTexels{"a", 16'384, 16'384}), "lightmap QUOTA_TEXELS");
}

TEST(PointReceiver, PointsThatCannotBeAreNamed) {
  EXPECT_EQ(Fault(Given({{}, {}})), "");
  EXPECT_EQ(Fault(GivenPoints{}), "given RANGE");
  EXPECT_EQ(Fault(Given(std::vector<SurfacePoint>(kMaxGivenPoints + 1))), "given QUOTA_POINTS");
  EXPECT_EQ(Fault(Given({{}, {.position = Vec3(0, kNan, 0)}})), "given[1].position NON_FINITE");
  EXPECT_EQ(Fault(Given({{.position = Vec3(INFINITY)}})), "given[0].position NON_FINITE");
  EXPECT_EQ(Fault(Given({{.position = Vec3(2e9f)}})), "given[0].position OUT_OF_BOUNDS");
  EXPECT_EQ(Fault(Given({{}, {}, {.normal = Vec3(0)}})), "given[2].normal RANGE");
  EXPECT_EQ(Fault(Given({{.normal = Vec3(kNan)}})), "given[0].normal RANGE");
}

TEST(PointReceiver, HashTellsDifferentOnesApart) {
  std::vector<PointReceiver> receivers = {Picture(),
                                          LightmapTexels{"a", 3, 4},
                                          LightmapTexels{"a", 4, 3},
                                          LightmapTexels{"b", 3, 4},
                                          GivenPoints{},
                                          Given({{}}),
                                          Given({{}, {}}),
                                          Given({{.normal = {0, 0, 1}}})};
  PicturePixels picture = Picture();
  picture.camera.fov_y_deg = 41;
  receivers.push_back(picture);
  picture = Picture();
  picture.crop = {.x = 1, .y = 0, .width = 1, .height = 1};
  receivers.push_back(picture);
  picture = Picture();
  picture.first = {.x = 1, .y = 0, .width = 1, .height = 1};
  receivers.push_back(picture);
  for (size_t i = 0; i < receivers.size(); ++i) {
    for (size_t k = 0; k < receivers.size(); ++k) {
      EXPECT_EQ(HashOf(receivers[i]) == HashOf(receivers[k]), i == k) << i << " " << k;
      EXPECT_EQ(receivers[i] == receivers[k], i == k) << i << " " << k;
    }
  }
  EXPECT_EQ(Given({{}}), Given({{}}));  // though their memory is not the same
}

}  // namespace
}  // namespace penumbra
