// What pictures are made of shadow volumes.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "render/light_view/auto_depth_source.h"
#include "render/technique/shadow_volume/shadow_volume_builder.h"
#include "tests/gl/display/thin_renderer_fixture.h"

namespace penumbra {
namespace {

// A wall in the plane z = 0 with a card before its left half, and lights far before both.
class VolumePicturesTest : public ThinRendererTest {
 protected:
  static constexpr float kAmbient = 0.25f;

  static SceneDelta Wall(const std::vector<Vec3>& lights) {
    SceneDelta delta;
    delta.upsert_instances = {Card("wall", Vec3(1), 0, 3), Card("card", Vec3(1), 0.5f, 0.3f)};
    for (size_t i = 0; i < lights.size(); ++i) {
      delta.upsert_lights.push_back(
          {.id = "light" + std::to_string(i),
           .shape = PointLight{.position = lights[i], .intensity = Vec3(100)}});
    }
    return delta;
  }
  std::vector<std::shared_ptr<const Artifact>> Artifacts(const Scene& scene) {
    std::vector<std::shared_ptr<const Artifact>> artifacts;
    for (const auto& [id, light] : scene.lights()) {
      AutoDepthSource source(scene, bvhs_, arena_);
      auto mesh = BuildShadowVolumes(scene, *light, {.resolution = 256}, source, {}).value();
      Artifact artifact{.header = {.light_id = id}, .payload = std::move(mesh)};
      artifacts.push_back(std::make_shared<Artifact>(std::move(artifact)));
    }
    return artifacts;
  }
  Picture Draw(const Scene& scene, const std::vector<std::shared_ptr<const Artifact>>& artifacts,
               const VolumeLook& look = {}, float clip_radiance = 1e30f) {
    RenderOptions options = kSquare;
    options.ambient = Vec3(kAmbient);
    options.volume_look = look;
    options.clip_radiance = clip_radiance;
    const auto picture = renderer_->Render(*context_, scene, artifacts, kFront, options);
    EXPECT_TRUE(picture.ok()) << picture.status();
    return *picture;
  }

  CasterBvhs bvhs_;
  tbb::task_arena arena_{2};
};

// The light from the left puts the card's shadow to the right of it, where the eye sees the wall.
constexpr Vec3 kLeft(-3, 0, 4), kRight(3, 0, 4);
constexpr int kMiddle = 32, kInShadow = 49, kLit = 4;

TEST_F(VolumePicturesTest, ShadingsOfShadows) {
  const auto scene = SceneOf(Wall({kLeft}));
  const auto artifacts = Artifacts(*scene);
  const Picture plain = Draw(*scene, {});
  const float lit = plain.At(kLit, kMiddle).x, unshadowed = plain.At(kInShadow, kMiddle).x;
  ASSERT_GT(lit, 2 * kAmbient);
  const Picture ambient = Draw(*scene, artifacts);
  EXPECT_NEAR(ambient.At(kLit, kMiddle).x, lit, 1e-5f * lit);
  EXPECT_NEAR(ambient.At(kInShadow, kMiddle).x, kAmbient, 1e-6f);
  const Picture half =
      Draw(*scene, artifacts, {.shading = VolumeShading::kComposited, .opacity = 0.4f});
  EXPECT_NEAR(half.At(kLit, kMiddle).x, lit, 1e-5f * lit);
  EXPECT_NEAR(half.At(kInShadow, kMiddle).x, 0.6f * unshadowed, 1e-5f * unshadowed);
  const Picture black = Draw(*scene, artifacts, {.shading = VolumeShading::kBlack});
  EXPECT_NEAR(black.At(kLit, kMiddle).x, lit, 1e-5f * lit);
  EXPECT_EQ(black.At(kInShadow, kMiddle).x, 0.0f);
  for (const Picture* picture : {&ambient, &half, &black}) {
    for (const Vec4& pixel : picture->pixels) EXPECT_EQ(pixel.w, 1.0f);
  }
}

TEST_F(VolumePicturesTest, LightsAddUp) {
  const auto scene = SceneOf(Wall({kLeft, kRight}));
  const Picture picture = Draw(*scene, Artifacts(*scene));
  const Picture left = Draw(*SceneOf(Wall({kLeft})), {});
  const Picture right = Draw(*SceneOf(Wall({kRight})), {});
  EXPECT_NEAR(picture.At(kInShadow, kMiddle).x, right.At(kInShadow, kMiddle).x, 1e-5f);
  const int mirrored = 63 - kInShadow;
  EXPECT_NEAR(picture.At(mirrored, kMiddle).x, left.At(mirrored, kMiddle).x, 1e-5f);
  const Vec4 both = left.At(kMiddle, 2) + right.At(kMiddle, 2) - Vec4(kAmbient);
  EXPECT_NEAR(picture.At(kMiddle, 2).x, both.x, 1e-5f);
  // What is added up is cut as one.
  const Picture cut = Draw(*scene, Artifacts(*scene), {}, 0.9f * both.x);
  EXPECT_NEAR(cut.At(kMiddle, 2).x, 0.9f * both.x, 1e-6f);
}

TEST_F(VolumePicturesTest, PassesSmoothEdges) {
  const auto scene = SceneOf(Wall({kLeft}));
  const auto artifacts = Artifacts(*scene);
  const auto shadow_of = [&](int passes, std::set<int>& levels) {
    const Picture picture = Draw(*scene, artifacts, {.passes = passes});
    const Picture plain = Draw(*scene, {});
    double sum = 0;
    for (size_t i = 0; i < picture.pixels.size(); ++i) {
      const double light = plain.pixels[i].x - kAmbient;
      const double part = light > 0 ? (picture.pixels[i].x - kAmbient) / light : 0;
      levels.insert(static_cast<int>(std::lround(16 * part)));
      sum += part;
    }
    return sum;
  };
  std::set<int> few, many;
  const double hard = shadow_of(1, few), smooth = shadow_of(16, many);
  EXPECT_GT(many.size(), few.size());
  EXPECT_NEAR(smooth, hard, 0.02 * hard);
}

TEST_F(VolumePicturesTest, WhatDoesNotReceiveStaysLit) {
  SceneDelta delta = Wall({kLeft});
  delta.upsert_instances[0].receives = false;
  const auto scene = SceneOf(delta);
  const float lit = Draw(*scene, {}).At(kInShadow, kMiddle).x;
  for (const VolumeShading shading :
       {VolumeShading::kAmbient, VolumeShading::kComposited, VolumeShading::kBlack}) {
    const Picture picture = Draw(*scene, Artifacts(*scene), {.shading = shading});
    EXPECT_NEAR(picture.At(kInShadow, kMiddle).x, lit, 1e-5f * lit);
  }
}

// Each light counts once, however many surfaces there are at one place.
TEST_F(VolumePicturesTest, SurfacesAtOnePlaceAreLitOnce) {
  SceneDelta delta = Wall({kLeft, kRight});
  const auto once = SceneOf(delta);
  Instance again = delta.upsert_instances[0];
  again.id = "wall-again";
  again.casts = false;
  delta.upsert_instances.push_back(again);
  const auto twice = SceneOf(delta);
  const Picture one = Draw(*once, Artifacts(*once)), two = Draw(*twice, Artifacts(*twice));
  for (const int x : {kLit, kInShadow, 63 - kInShadow}) {
    EXPECT_NEAR(two.At(x, kMiddle).x, one.At(x, kMiddle).x, 1e-5f);
  }
}

// Pictures of several squares are the same as their parts.
TEST_F(VolumePicturesTest, SquaresFitTogether) {
  const auto scene = SceneOf(Wall({kLeft}));
  const auto artifacts = Artifacts(*scene);
  RenderOptions options = kSquare;
  options.width = options.height = 640;
  options.samples_per_side = 2;
  const auto picture = renderer_->Render(*context_, *scene, artifacts, kFront, options);
  ASSERT_TRUE(picture.ok()) << picture.status();
  const Picture small = Draw(*scene, artifacts), plain = Draw(*scene, {});
  size_t different = 0;
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      const bool is_dark = small.At(x, y).x < 0.6f * plain.At(x, y).x;
      const bool is_dark_there =
          picture->At(10 * x + 5, 10 * y + 5).x - 1 + kAmbient < 0.6f * plain.At(x, y).x;
      different += is_dark != is_dark_there;
    }
  }
  EXPECT_LT(different, 64u);
}

TEST_F(VolumePicturesTest, GivesWayToOtherArtifactsOfTheLight) {
  SceneDelta delta = Wall({kLeft});
  delta.upsert_receivers = {
      {.id = "patch",
       .shape = Parallelogram{
           .origin = Vec3(-3, -3, 0), .edge_u = Vec3(6, 0, 0), .edge_v = Vec3(0, 6, 0)}}};
  const auto scene = SceneOf(delta);
  auto artifacts = Artifacts(*scene);
  artifacts.push_back(
      ArtifactOf(*scene, "light0", "patch", 1, [](uint32_t, uint32_t) { return 1; }));
  const Picture picture = Draw(*scene, artifacts), plain = Draw(*scene, {});
  EXPECT_NEAR(picture.At(kInShadow, kMiddle).x, plain.At(kInShadow, kMiddle).x, 1e-3f);
}

TEST_F(VolumePicturesTest, WrongLooksAreRefused) {
  const auto scene = SceneOf(Wall({kLeft}));
  for (const VolumeLook& look : {VolumeLook{.passes = 0}, VolumeLook{.passes = 65},
                                 VolumeLook{.opacity = -0.1f}, VolumeLook{.opacity = NAN}}) {
    RenderOptions options = kSquare;
    options.volume_look = look;
    EXPECT_EQ(renderer_->Render(*context_, *scene, {}, kFront, options).status().code(),
              absl::StatusCode::kInvalidArgument);
  }
}

}  // namespace
}  // namespace penumbra
