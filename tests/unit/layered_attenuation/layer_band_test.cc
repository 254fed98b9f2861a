#include "render/technique/layered_attenuation/layer_band.h"

#include <vector>

#include "gtest/gtest.h"

namespace penumbra {
namespace {

constexpr uint32_t kMost = 16;
constexpr bool kFromInfinity = false;
constexpr LayerTolerance kTolerance{.pixels = 1, .width = 0.01f};  // at nearness 1 flat: ±0.01

PixelSurface At(float nearness, Vec2 gradient) {
  return {.column = 1, .row = 5, .plane = {.at = {}, .nearness = nearness, .gradient = gradient}};
}

class LayerBandTest : public ::testing::Test {
 protected:
  LayerBand::Found Add(float nearness, Vec2 gradient = {}, uint32_t most = kMost) {
    return band_.Add(At(nearness, gradient), kTolerance, kFromInfinity, most);
  }

  LayerBand band_{3, 4, 2};
};

TEST_F(LayerBandTest, ASurfaceIsALayerOnce) {
  EXPECT_EQ(Add(1.0f), LayerBand::Found::kNew);
  EXPECT_EQ(Add(1.009f), LayerBand::Found::kKnown);
  EXPECT_EQ(Add(0.991f), LayerBand::Found::kKnown);
  EXPECT_EQ(Add(0.98f), LayerBand::Found::kNew);
  EXPECT_EQ(band_.size(), 2u);
}

// A petal seen on its edge must not take the floor's layer away: the floor's points look for it.
TEST_F(LayerBandTest, ASteepLayerDoesNotSwallowAFlatSurfaceBehind) {
  EXPECT_EQ(Add(1.0f, Vec2(0.16f, 0.16f)), LayerBand::Found::kNew);
  EXPECT_EQ(Add(0.8f), LayerBand::Found::kNew);
}

TEST_F(LayerBandTest, ASteepSurfaceIsKnownByALayerInItsReach) {
  EXPECT_EQ(Add(1.0f), LayerBand::Found::kNew);
  EXPECT_EQ(Add(0.8f, Vec2(0.16f, 0.16f)), LayerBand::Found::kKnown);
}

TEST_F(LayerBandTest, NoPixelHasMoreThanTheMost) {
  EXPECT_EQ(Add(1.0f, {}, 1), LayerBand::Found::kNew);
  EXPECT_EQ(Add(0.5f, {}, 1), LayerBand::Found::kTooMany);
  EXPECT_EQ(band_.size(), 1u);
}

TEST_F(LayerBandTest, LayersComeNearestFirstAndEmptyPixelsHaveNone) {
  Add(0.5f);
  Add(1.0f);
  LdiFace face;
  band_.Append(kFromInfinity, /*unhidden=*/3, face);
  EXPECT_EQ(face.offsets, (std::vector<uint32_t>{0, 0, 0, 0, 0, 2}));  // before each pixel
  EXPECT_EQ(face.depths, (std::vector<float>{1, 2}));
  EXPECT_EQ(face.counts, (std::vector<uint16_t>{3, 3}));
}

}  // namespace
}  // namespace penumbra
