#include "render/artifact/artifact.h"

#include <gtest/gtest.h>

#include "render/scene/unoccluded_light.h"

namespace penumbra {
namespace {

// 4×2 texels on a skew patch, the count of texel (i, j) being 4j + i of 8.
Artifact Example() {
  SoftShadowTexture texture;
  texture.receiver = {
      .patch = {Vec3(1, 2, 3), Vec3(4, 0, 0), Vec3(1, 0, -2)}, .width = 4, .height = 2};
  texture.light = {.id = "l",
                   .shape = SphereLight{.center = Vec3(2, 5, 2), .radiance = Vec3(1, 2, 3)}};
  texture.visibility = {4, 2, 8, {0, 1, 2, 3, 4, 5, 6, 7}};
  return {.header = {}, .payload = texture};
}

TEST(Visibility, FindsTheTexelOfAPoint) {
  const Artifact artifact = Example();
  const ReceiverPatch& receiver = std::get<SoftShadowTexture>(artifact.payload).receiver;
  for (uint32_t j = 0; j < 2; ++j) {
    for (uint32_t i = 0; i < 4; ++i) {
      const Vec3 above = receiver.TexelCenter(i, j) + Vec3(0, 0.7f, 0);
      EXPECT_FLOAT_EQ(Visibility(artifact, above, Vec3(0, 1, 0)), (4 * j + i) / 8.0f);
    }
  }
  EXPECT_FLOAT_EQ(Visibility(artifact, Vec3(100, 0, -100), Vec3(0, 1, 0)), 7 / 8.0f);
  EXPECT_FLOAT_EQ(Visibility(artifact, Vec3(-100, 0, 100), Vec3(0, 1, 0)), 0.0f);
}

// A camera at (0, 0, 5) that looks along −z: the plane z = 0 fills its picture from −1 to 1.
ViewShadow Picture() {
  ViewShadow shadow;
  shadow.points =
      PicturePixels{.camera = {.eye = {0, 0, 5}, .target = {0, 0, 0}, .fov_y_deg = 22.619865f},
                    .width = 4,
                    .height = 4,
                    .crop = {.x = 1, .y = 0, .width = 3, .height = 2}};
  shadow.visibility = {3, 2, 8, {0, 1, 2, 3, 4, 5}};
  auto mask = std::make_shared<CoverageMask>(3, 2);
  mask->Set(4);
  shadow.coverage = mask;
  return shadow;
}

TEST(Visibility, FindsThePixelOfAPoint) {
  const Artifact artifact{.header = {}, .payload = Picture()};
  for (uint32_t j = 0; j < 2; ++j) {
    for (uint32_t i = 0; i < 3; ++i) {
      // Pixel (i + 1, j) of the whole picture, whose row 0 is the top.
      const Vec3 point(-1 + 0.5f * (i + 1.5f), 1 - 0.5f * (j + 0.5f), 0);
      EXPECT_FLOAT_EQ(Visibility(artifact, point, Vec3(0, 0, 1)), (3 * j + i) / 8.0f);
      EXPECT_EQ(Covers(artifact, point), i == 1 && j == 1);
    }
  }
  EXPECT_FALSE(Covers(artifact, Vec3(0, 0, 10)));  // behind the camera
}

TEST(Visibility, HasNoPlaceForPointsWithoutOne) {
  ViewShadow shadow = Picture();
  shadow.points = GivenPoints{};
  EXPECT_FALSE(Covers({.header = {}, .payload = shadow}, Vec3(0)));
  EXPECT_EQ(Visibility({.header = {}, .payload = shadow}, Vec3(0), Vec3(0, 1, 0)), 0.0f);
}

TEST(TexelsOf, IsTheGridOfArtifactsThatAreOne) {
  const ArtifactPayload texture = Example().payload, picture = Picture(), ldi = AttenuationLdi{};
  EXPECT_EQ(TexelsOf(texture)->visibility.width, 4u);
  EXPECT_EQ(TexelsOf(picture)->visibility.width, 3u);
  EXPECT_EQ(TexelsOf(ldi), nullptr);
  EXPECT_EQ(LightOf(texture).id, "l");
}

TEST(ReflectedRadiance, IsTheProductOfItsThreeFactors) {
  Artifact artifact = Example();
  auto& texture = std::get<SoftShadowTexture>(artifact.payload);
  texture.receiver.reflectance = Vec3(0.5f, 0.25f, 1);
  texture.receiver.two_sided = false;
  const RadianceTexture radiance = ReflectedRadiance(texture);
  ASSERT_EQ(radiance.texels.size(), 8u);
  const Vec3 point = texture.receiver.TexelCenter(3, 1);
  const Vec3 expected =
      Vec3(0.5f, 0.25f, 1) * UnoccludedRadiance(texture.light, point, Vec3(0, 1, 0)) * 0.875f;
  EXPECT_LT(glm::length(radiance.texels[7] - expected), 1e-7f);
  EXPECT_GT(expected.x, 0);

  // From below, a one-sided patch stays dark and a two-sided one does not.
  std::get<SphereLight>(texture.light.shape).center.y = -5;
  EXPECT_EQ(ReflectedRadiance(texture).texels[7], Vec3(0));
  texture.receiver.two_sided = true;
  EXPECT_GT(ReflectedRadiance(texture).texels[7].x, 0);
}

}  // namespace
}  // namespace penumbra
