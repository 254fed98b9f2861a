#include "render/artifact/radiance_format.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "render/artifact/soft_shadow_texture.h"
#include "tests/support/random_scene.h"

namespace penumbra {
namespace {

constexpr float kScales[] = {1.0f, 0.3f, 7.25f, 1e-6f, 12345.678f, 1e30f};

TEST(RadianceFormat, CodesSurviveARoundTrip) {
  for (const RadianceFormat format : {RadianceFormat::kUnorm8, RadianceFormat::kUnorm16}) {
    const uint32_t last = format == RadianceFormat::kUnorm8 ? 255 : 65535;
    for (const float scale : kScales) {
      const RadianceCodec codec(format, scale);
      for (uint32_t code = 0; code <= last; ++code) {
        ASSERT_EQ(codec.Encode(codec.Decode(static_cast<uint16_t>(code))), code) << scale;
      }
      EXPECT_EQ(codec.Decode(static_cast<uint16_t>(last)), scale);
      EXPECT_EQ(codec.Encode(2 * scale), last);
      EXPECT_EQ(codec.Encode(-scale), 0);
      EXPECT_EQ(codec.Encode(std::numeric_limits<float>::quiet_NaN()), 0);
    }
  }
  const RadianceCodec half(RadianceFormat::kHalf, 1);
  for (uint32_t code = 0; code < 0x7c00; ++code) {
    ASSERT_EQ(half.Encode(half.Decode(static_cast<uint16_t>(code))), code);
  }
  EXPECT_EQ(half.Decode(half.Encode(1e6f)), 65504.0f);
}

TEST(RadianceFormat, ErrorsAreWithinWhatIsStated) {
  testing::Dice dice(5);
  for (int trial = 0; trial < 100000; ++trial) {
    const float scale = kScales[trial % 6];
    const double value = scale * dice.Between(0, 1);
    const auto error = [&](RadianceFormat format) {
      const RadianceCodec codec(format, scale);
      return std::abs(codec.Decode(codec.Encode(static_cast<float>(value))) - value);
    };
    const double rounding = 1.2e-7 * value;
    EXPECT_LE(error(RadianceFormat::kUnorm8), double{scale} / 510 + rounding);
    EXPECT_LE(error(RadianceFormat::kUnorm16), double{scale} / 131070 + rounding);
    if (value < 65504) {
      EXPECT_LE(error(RadianceFormat::kHalf),
                std::max(std::ldexp(value, -11), std::ldexp(1, -25)) + rounding);
    }
  }
}

TEST(RadianceFormat, RoundToTellsWhatTheTexelsAre) {
  const std::vector<Vec3> texels = {Vec3(0, 0.1f, 0.2f), Vec3(1, 2, 3)};
  RadianceTexture radiance{2, 1, texels};
  RoundTo(RadianceFormat::kUnorm8, 2, radiance);
  EXPECT_EQ(radiance.format, RadianceFormat::kUnorm8);
  EXPECT_EQ(radiance.scale, 2);
  EXPECT_EQ(radiance.texels[1].y, 2);
  EXPECT_EQ(radiance.texels[1].z, 2);  // no more than the scale
  EXPECT_FLOAT_EQ(radiance.texels[0].y, 13 * 2 / 255.0f);
  RadianceTexture exact{2, 1, texels};
  RoundTo(RadianceFormat::kFloat32, 2, exact);
  EXPECT_EQ(exact.texels, texels);
  EXPECT_EQ(exact.scale, 1);
}

}  // namespace
}  // namespace penumbra
