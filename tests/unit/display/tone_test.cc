#include "client/display/tone.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace penumbra {
namespace {

// Values of IEC 61966-2-1: half of full light is byte 188, byte 128 is 21.586 % of full light.
TEST(ToneTest, SrgbHasItsKnownValues) {
  EXPECT_NEAR(SrgbFromLinear(0.5f), 0.735357f, 1e-5);
  EXPECT_NEAR(SrgbFromLinear(0.21586f), 128 / 255.0, 1e-4);
  EXPECT_NEAR(SrgbFromLinear(0.002f), 0.02584f, 1e-6) << "the straight piece";
  EXPECT_EQ(SrgbFromLinear(0), 0);
  EXPECT_EQ(SrgbFromLinear(1), 1);
  EXPECT_EQ(SrgbFromLinear(1e30f), 1);
  EXPECT_EQ(SrgbFromLinear(-1), 0);
  EXPECT_EQ(SrgbFromLinear(std::numeric_limits<float>::quiet_NaN()), 0);
}

TEST(ToneTest, ExposesThePictureAndNotTheBackground) {
  const Picture picture = {.width = 3,
                           .height = 1,
                           .pixels = {Vec4(0.25f, 0.1f, 0, 1), Vec4(0), Vec4(0.125f, 0, 0, 0.5f)}};
  const auto rgb = ToSrgb(picture, {.exposure = 2, .background = {0, 0, 0.5f}});
  EXPECT_THAT(rgb, testing::ElementsAre(188, 124, 0, 0, 0, 188, 137, 0, 137));
}

TEST(ToneTest, SuggestedExposureShowsTheBrightSurfacesAsLightGrey) {
  Picture picture = {.width = 100, .height = 10, .pixels = std::vector<Vec4>(1000, Vec4(0))};
  for (int i = 0; i < 500; ++i) picture.pixels[i] = Vec4(Vec3(20), 1);
  for (int i = 0; i < 20; ++i) picture.pixels[i] = Vec4(Vec3(1e5f), 1);  // a lamp
  EXPECT_NEAR(SuggestExposure(picture), 0.6f / 20, 1e-5);
}

TEST(ToneTest, SuggestsSomethingForEveryPicture) {
  EXPECT_EQ(SuggestExposure({}), 1);
  EXPECT_EQ(SuggestExposure({.width = 1, .height = 1, .pixels = {Vec4(0, 0, 0, 1)}}), 1);
  Picture mostly_dark = {
      .width = 100, .height = 1, .pixels = std::vector<Vec4>(100, Vec4(0, 0, 0, 1))};
  mostly_dark.pixels[7] = Vec4(3, 3, 3, 1);
  EXPECT_NEAR(SuggestExposure(mostly_dark), 0.2f, 1e-5);
}

}  // namespace
}  // namespace penumbra
