// Row A20 of the catalogue: artifacts of no size, of one texel, of the largest side, and beyond.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/scene/field_error.h"
#include "render/scene/scene.h"
#include "render/technique/technique.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

using ::testing::HasSubstr;

constexpr uint32_t kHuge = uint32_t{1} << 31;

std::shared_ptr<const Scene> SceneWithALight() {
  return Scene::Empty("s")->Apply({.upsert_lights = {{"light", PointLight{}}}}).value();
}

absl::Status Refusal(uint32_t width, uint32_t height) {
  Receiver receiver = FloorReceiver("receiver", 1, width);
  receiver.height = height;
  const auto before = SceneWithALight();
  const auto hash = before->content_hash();
  const absl::Status status = before->Apply({.upsert_receivers = {receiver}}).status();
  EXPECT_EQ(before->content_hash(), hash);
  return status;
}

void ExpectError(const absl::Status& status, absl::StatusCode code, const char* reason,
                 const char* field) {
  EXPECT_EQ(status.code(), code) << status;
  EXPECT_EQ(ErrorReason(status), reason) << status;
  EXPECT_THAT(ErrorFieldPath(status), HasSubstr(field)) << status;
}

TEST(SizesTest, A20ReceiversOfNoSizeGetOneAndOfOneTexelKeepIt) {
  EXPECT_TRUE(Refusal(0, 0).ok());
  EXPECT_TRUE(Refusal(1, 1).ok());
  EXPECT_TRUE(Refusal(16384, 4096).ok());
}

TEST(SizesTest, A20ReceiversBeyondTheLimits) {
  ExpectError(Refusal(16384, 16384), absl::StatusCode::kResourceExhausted, "QUOTA_TEXELS", "width");
  ExpectError(Refusal(16384, 4097), absl::StatusCode::kResourceExhausted, "QUOTA_TEXELS", "width");
  for (const uint32_t side : {16385u, kHuge, ~0u}) {
    ExpectError(Refusal(side, 1), absl::StatusCode::kInvalidArgument, "RANGE", "width");
    ExpectError(Refusal(1, side), absl::StatusCode::kInvalidArgument, "RANGE", "height");
    // 2³¹ by 2³¹ is more than 32 bits hold, ~0 by ~0 nearly more than 64.
    ExpectError(Refusal(side, side), absl::StatusCode::kInvalidArgument, "RANGE", "width");
  }
}

TEST(SizesTest, A20MapsOfALight) {
  const auto scene = SceneWithALight();
  for (const uint32_t resolution : {0u, 16385u, kHuge, ~0u}) {
    for (const TechniqueParams& params :
         {TechniqueParams(LayeredAttenuationParams{.resolution = resolution}),
          TechniqueParams(ShadowWidthParams{.resolution = resolution}),
          TechniqueParams(ShadowVolumeParams{.resolution = resolution})}) {
      const absl::Status status =
          TechniqueFor(params).Check(*scene, {.params = params, .light_id = "light"});
      ExpectError(status, absl::StatusCode::kInvalidArgument, "RANGE", "resolution");
    }
  }
}

TEST(SizesTest, A20Pictures) {
  const auto scene = SceneWithALight();
  const auto check = [&](uint32_t width, uint32_t height) {
    const TechniqueParams params = CoherentRaytraceParams{};
    return TechniqueFor(params).Check(
        *scene,
        {.params = params,
         .light_id = "light",
         .points = PicturePixels{.camera = {.eye = {0, 0, 5}}, .width = width, .height = height}});
  };
  EXPECT_TRUE(check(1, 1).ok()) << check(1, 1);
  for (const uint32_t side : {0u, 16385u, kHuge}) {
    ExpectError(check(side, 1), absl::StatusCode::kInvalidArgument, "RANGE", "width");
    ExpectError(check(1, side), absl::StatusCode::kInvalidArgument, "RANGE", "height");
  }
  ExpectError(check(16384, 16384), absl::StatusCode::kResourceExhausted, "QUOTA_TEXELS", "points");
}

}  // namespace
}  // namespace penumbra::testing
