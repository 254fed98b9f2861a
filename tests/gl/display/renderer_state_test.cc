// What the thin renderer keeps from one picture to the next, and what it refuses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/gl/display/thin_renderer_fixture.h"
#include "tests/support/test_device.h"

namespace penumbra {
namespace {

using ::testing::HasSubstr;

TEST_F(ThinRendererTest, TheSameSceneGivesTheSameBits) {
  const SceneDelta delta = {
      .upsert_instances = {Card("a", Vec3(0.7f), -1, 3),
                           {.id = "b",
                            .mesh = Cuboid({-0.5f, -0.5f, -0.5f}, {0.5f, 0.2f, 0.5f}),
                            .color = Vec3(0.3f)}},
      .upsert_lights = {{.id = "l", .shape = SphereLight{.center = {1, 1, 1}}}}};
  RenderOptions options = kSquare;
  options.samples_per_side = 2;
  const Camera camera = FrameScene({.min = Vec3(-1), .max = Vec3(1)}, 1);
  const Picture first = Render(delta, options, camera);
  EXPECT_EQ(first.pixels, Render(delta, options, camera).pixels);
  auto fresh = ThinRenderer::Create(*context_);
  ASSERT_TRUE(fresh.ok()) << fresh.status();
  const auto again = (*fresh)->Render(*context_, *SceneOf(delta), {}, camera, options);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(first.pixels, again->pixels);
}

TEST_F(ThinRendererTest, OnlyWhatIsNewIsUploaded) {
  const Receiver receiver = {
      .id = "patch",
      .shape = Parallelogram{.origin = {-1, -1, -1}, .edge_u = {2, 0, 0}, .edge_v = {0, 2, 0}},
      .width = 5,
      .height = 5};
  const AreaLight a = {.id = "a", .shape = PointLight{}}, b = {.id = "b", .shape = PointLight{}};
  SceneDelta delta = {.upsert_instances = {Card("card", Vec3(1), 0, 0.5f)},
                      .upsert_lights = {a, b},
                      .upsert_receivers = {receiver}};
  const auto scene = SceneOf(delta);
  const auto of_a = ArtifactOf(*scene, "a", "patch", 1, [](uint32_t, uint32_t) { return 1; });
  const auto of_b = ArtifactOf(*scene, "b", "patch", 1, [](uint32_t, uint32_t) { return 1; });
  const auto render = [&](const Scene& s, std::vector<std::shared_ptr<const Artifact>> artifacts) {
    EXPECT_TRUE(renderer_->Render(*context_, s, artifacts, kFront, kSquare).ok());
    return renderer_->uploads();
  };
  const auto first = render(*scene, {of_a, of_b});
  EXPECT_EQ(first.meshes, 2) << "the card and the receiver's square";
  EXPECT_EQ(first.artifacts, 2);
  auto next = render(*scene, {of_a, of_b});
  EXPECT_EQ(next.meshes, 2);
  EXPECT_EQ(next.artifacts, 2);
  const auto new_b = ArtifactOf(*scene, "b", "patch", 1, [](uint32_t, uint32_t) { return 0; });
  next = render(*scene, {of_a, new_b});
  EXPECT_EQ(next.artifacts, 3);
  delta.upsert_instances[0].world_from_mesh[3] = Vec3(0.1f, 0, 0);
  delta.upsert_instances.push_back(Card("twin", Vec3(1), 0, 0.5f));
  next = render(*SceneOf(delta), {of_a, new_b});
  EXPECT_EQ(next.meshes, 2) << "a moved instance and a second one of the same shape need no upload";
  EXPECT_EQ(next.artifacts, 3);
}

TEST_F(ThinRendererTest, WhatIsNoLongerDrawnIsFreed) {
  const int before = context_->object_count();
  Render({.upsert_instances = {Card("card", Vec3(1))}});
  const int with_card = context_->object_count();
  EXPECT_GT(with_card, before);
  Render({});
  EXPECT_LT(context_->object_count(), with_card);
}

TEST_F(ThinRendererTest, GoesOnWithANewContextAfterALoss) {
  const SceneDelta delta = {.upsert_instances = {Card("card", Vec3(0.5f))}};
  const Picture before = Render(delta);
  context_->SimulateLoss();
  const auto lost = renderer_->Render(*context_, *SceneOf(delta), {}, kFront, kSquare);
  EXPECT_EQ(lost.status().code(), absl::StatusCode::kUnavailable);
  auto fresh = gl::Context::Create({.device = TestDevice()});
  ASSERT_TRUE(fresh.ok()) << fresh.status();
  context_ = *std::move(fresh);
  EXPECT_EQ(Render(delta).pixels, before.pixels);
}

TEST_F(ThinRendererTest, RefusesWhatItCannotDraw) {
  RenderOptions options = kSquare;
  options.width = 0;
  EXPECT_THAT(std::string(Refusal(kFront, options).message()),
              HasSubstr("width: found 0, need 1 to"));
  options = kSquare;
  options.samples_per_side = 9;
  EXPECT_THAT(std::string(Refusal(kFront, options).message()),
              HasSubstr("samples_per_side: found 9"));
  options = kSquare;
  options.ambient.y = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(Refusal(kFront, options).code(), absl::StatusCode::kInvalidArgument);
  Camera camera = kFront;
  camera.target = camera.eye;
  EXPECT_THAT(std::string(Refusal(camera, kSquare).message()),
              HasSubstr("camera.target: found the eye"));
}

}  // namespace
}  // namespace penumbra
