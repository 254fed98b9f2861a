#include "proto/convert/points_convert.h"

#include <gtest/gtest.h>

#include <vector>

#include "proto/convert/spec_convert.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

TEST(PointsConvertTest, EveryKindGoesThereAndBack) {
  const PointReceiver receivers[] = {
      PicturePixels{
          .camera = {.eye = {1, 2, 3}, .target = {4, 5, 7}, .up = {0, 0, 1}, .fov_y_deg = 55},
          .width = 640,
          .height = 480,
          .crop = {1, 2, 3, 4},
          .first = {2, 3, 1, 2}},
      PicturePixels{.camera = {}, .width = 3, .height = 2},
      LightmapTexels{"table", 64, 32},
      GivenPoints{std::make_shared<const std::vector<SurfacePoint>>(
          std::vector<SurfacePoint>{{{1, 2, 3}, {0, 0, 1}}, {{4, 5, 6}, {1, 0, 0}}})},
  };
  for (const PointReceiver& receiver : receivers) {
    const auto back = FromProto(ToProto(receiver));
    ASSERT_TRUE(back.ok()) << back.status();
    EXPECT_EQ(*back, receiver);
  }
}

TEST(PointsConvertTest, WhatIsNoneIsNamed) {
  EXPECT_EQ(ErrorReason(FromProto(v1::PointReceiver()).status()), "MISSING_FIELD");
  v1::PointReceiver proto;
  proto.mutable_given()->set_positions(std::string(13, '\0'));
  EXPECT_EQ(ErrorFieldPath(FromProto(proto).status()), "given.positions");
  proto.mutable_given()->set_positions(std::string(24, '\0'));
  proto.mutable_given()->set_normals(std::string(12, '\0'));
  EXPECT_EQ(ErrorFieldPath(FromProto(proto).status()), "given.normals");
}

TEST(PointsConvertTest, TechniquesForReceiversTakeNone) {
  v1::ArtifactSpec proto =
      ToProto(ArtifactSpec{.params = SoftTextureParams{}, .light_id = "l", .receiver_id = "r"});
  *proto.mutable_points() = ToProto(PointReceiver(LightmapTexels{"table", 64, 32}));
  const auto spec = FromProto(proto);
  EXPECT_EQ(ErrorFieldPath(spec.status()), "spec.points");
  EXPECT_EQ(ErrorReason(spec.status()), "UNEXPECTED_FIELD");
}

}  // namespace
}  // namespace penumbra
