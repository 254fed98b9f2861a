// Rows A03 and A12 to A20: what is odd but means something is computed, and is finite.

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include "tests/integration/catalogue/catalogue_test.h"

namespace penumbra::testing {
namespace {

class LightRowsTest : public CatalogueTest {
 protected:
  // The floor's texture with radiance, after this delta.
  SoftShadowTexture After(const SceneDelta& delta, uint32_t samples = 16) {
    const auto result = session_->Commit(delta);
    EXPECT_FALSE(result.has_error()) << result.error().message();
    ArtifactSpec spec = FloorSpec(samples);
    std::get<SoftTextureParams>(spec.params).radiance = true;
    const uint64_t id = next_id_++;
    EXPECT_EQ(session_->Subscribe(id, spec, 4), absl::OkStatus());
    const ArtifactUpdate update = session_->AwaitUpdate(id, FinalAt(result.revision()));
    if (!update.artifact) return {};
    ExpectDefined(TextureOf(update), samples);
    return TextureOf(update);
  }
  SoftShadowTexture WithLight(LightShape shape, uint32_t samples = 16) {
    SceneDelta delta;
    delta.upsert_lights = {{.id = "lamp", .shape = std::move(shape)}};
    return After(delta, samples);
  }
  SoftShadowTexture WithBoxes(const std::vector<Affine>& places) {
    SceneDelta delta;
    for (size_t i = 0; i < places.size(); ++i) {
      delta.upsert_instances.push_back(Box({}, "added" + std::to_string(i)));
      delta.upsert_instances.back().world_from_mesh = places[i];
    }
    return After(delta);
  }

  static void ExpectDefined(const SoftShadowTexture& texture, uint32_t samples) {
    ASSERT_TRUE(texture.radiance);
    ASSERT_EQ(texture.visibility.counts.size(), 128u * 128);
    for (const Vec3& texel : texture.radiance->texels) {
      ASSERT_TRUE(IsFinite(texel) && texel.x >= 0 && texel.y >= 0 && texel.z >= 0);
    }
    for (const uint16_t count : texture.visibility.counts) ASSERT_LE(count, samples);
  }
  static size_t Dark(const SoftShadowTexture& texture) {
    return static_cast<size_t>(std::ranges::count(texture.visibility.counts, 0));
  }

  uint64_t next_id_ = 10;
};

TEST_F(LightRowsTest, A12WhatShrinksTendsToTheHardShadow) {
  const auto hard = WithLight(PointLight{.position = {0, 3, 0}}, 1);
  ASSERT_GT(Dark(hard), 200u);
  for (const LightShape& shape :
       {LightShape(SphereLight{.center = {0, 3, 0}, .radius = 1e-4f}),
        LightShape(DiskLight{.center = {0, 3, 0}, .normal = {0, -1, 0}, .radius = 1e-4f})}) {
    const auto soft = WithLight(shape, 16);
    size_t apart = 0;
    for (size_t i = 0; i < soft.visibility.counts.size(); ++i) {
      const auto at = static_cast<uint32_t>(i);
      apart += soft.visibility.Fraction(at % 128, at / 128) !=
               hard.visibility.Fraction(at % 128, at / 128);
    }
    EXPECT_LE(apart, 16u) << "texels whose centre lies within a fraction of a texel of the edge";
  }
}

TEST_F(LightRowsTest, A14LightsInThePlaneInAnOccluderAndOnAVertexHaveAResult) {
  WithLight(RectangleLight{.corner = {-1, 0, -1}, .edge_u = {2, 0, 0}, .edge_v = {0, 0, 2}});
  WithLight(RectangleLight{.corner = {-1, -1, 0}, .edge_u = {2, 0, 0}, .edge_v = {0, 2, 0}});
  WithLight(PointLight{.position = {0.25f, 0, 0.25f}});
  // The box is 0.6 m wide and stands around (0, 1, 0).
  const auto inside = WithLight(SphereLight{.center = {0, 1, 0}, .radius = 0.1f});
  EXPECT_EQ(Dark(inside), inside.visibility.counts.size()) << "nothing gets out of it";
  WithLight(PointLight{.position = {0.3f, 1.3f, 0.3f}});
  WithLight(PointLight{.position = {0.3f, 1.0f, 0.3f}});
  // Exactly above a texel's centre, and below the floor.
  WithLight(PointLight{.position = {1.0f / 64, 3, 1.0f / 64}});
  WithLight(PointLight{.position = {0, -1, 0}});
}

TEST_F(LightRowsTest, A15FlatMeansInvisibleAndMirrorsCastTheSameShadow) {
  const auto without = After(MoveBox({0, 1, 0}));
  EXPECT_EQ(WithBoxes({Placed({0.7f, 1, 0}, 0.0f)}).visibility.counts, without.visibility.counts);
  const auto with = WithBoxes({Placed({0.7f, 1, 0}, 0.2f)});
  EXPECT_GT(Dark(with), Dark(without));
  EXPECT_EQ(WithBoxes({Placed({0.7f, 1, 0}, Vec3(-0.2f, 0.2f, 0.2f))}).visibility.counts,
            with.visibility.counts);
  // Without thickness it is a sheet, not nothing.
  EXPECT_GT(Dark(WithBoxes({Placed({0.7f, 1, 0}, Vec3(0.2f, 0.0f, 0.2f))})), Dark(without));
}

// The box's lower face in the floor's plane, less than a rounding above it, and a hair below: what
// is under it is dark, what is a texel away from it is as without.
TEST_F(LightRowsTest, A18TouchingAndNearlyTouchingCastersAreDefined) {
  WithLight(PointLight{.position = {0, 3, 0}}, 1);
  for (const float gap : {0.0f, 1e-7f, -1e-7f, 1e-6f}) {
    const auto texture = WithBoxes({Placed({1.25f, 0.1f + gap, 1.25f}, 0.1f)});
    const auto at = [&](float x, float z) {
      return texture.visibility.Fraction(static_cast<uint32_t>((x + 2) * 32),
                                         static_cast<uint32_t>((2 - z) * 32));
    };
    EXPECT_EQ(at(1.25f, 1.25f), 0) << gap;
    EXPECT_EQ(at(1.20f, 1.30f), 0) << gap;
    EXPECT_EQ(at(1.10f, 1.10f), 1) << gap;
    EXPECT_EQ(at(-1.5f, -1.5f), 1) << gap;
  }
}

TEST_F(LightRowsTest, A18CastersAMillionTimesSmallerOrLargerAreDefined) {
  const auto before = After(MoveBox({0, 1, 0}));
  // A micrometre: between the rays to all texels' centres.
  const auto tiny = WithBoxes({Placed({1.01f, 0.01f, 1.01f}, 1e-6f)});
  size_t apart = 0;
  for (size_t i = 0; i < tiny.visibility.counts.size(); ++i) {
    apart += tiny.visibility.counts[i] != before.visibility.counts[i];
  }
  EXPECT_LE(apart, 1u);
  // A thousand kilometres wide, and three metres under the lamp's middle: everything is dark.
  const auto vast = WithBoxes({Placed({0, 1.5f, 0}, Vec3(1e6f, 0.1f, 1e6f))});
  EXPECT_EQ(Dark(vast), vast.visibility.counts.size());
}

// No size is given: by the receiver's length in the world, which the artifact tells.
TEST_F(LightRowsTest, A20ReceiversWithoutASizeAndOfOneTexel) {
  SceneDelta delta;
  delta.upsert_receivers = {FloorReceiver("sized", 4, 0), FloorReceiver("dot", 4, 1),
                            FloorReceiver("row", 4, 16384)};
  delta.upsert_receivers[2].height = 1;
  const auto result = session_->Commit(delta);
  ASSERT_FALSE(result.has_error()) << result.error().message();
  for (const auto& [receiver, width, height] :
       {std::tuple("sized", 256u, 256u), {"dot", 1u, 1u}, {"row", 16384u, 1u}}) {
    ArtifactSpec spec = FloorSpec();
    spec.receiver_id = receiver;
    ASSERT_EQ(session_->Subscribe(next_id_, spec, 4), absl::OkStatus());
    const auto update = session_->AwaitUpdate(next_id_++, IsFinal);
    EXPECT_EQ(TextureOf(update).visibility.width, width) << receiver;
    EXPECT_EQ(TextureOf(update).visibility.height, height) << receiver;
  }
}

}  // namespace
}  // namespace penumbra::testing
