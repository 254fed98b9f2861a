// What the thin renderer draws where, what it keeps, and what it refuses.
#include "client/display/thin_renderer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/gl/display/small_scenes.h"
#include "tests/gl/display/software_context.h"

namespace penumbra {
namespace {

using ::testing::HasSubstr;

// Looks along −z at the square [−1, 1]² in the plane z = 0, which fills the picture.
const Camera kFront = {
    .eye = {0, 0, 5}, .target = {0, 0, 0}, .up = {0, 1, 0}, .fov_y_deg = 22.6198649f};
const RenderOptions kSquare = {
    .width = 64, .height = 64, .samples_per_side = 1, .ambient = Vec3(1), .draws_lights = true};

Instance Card(const std::string& id, Vec3 color, float z = 0, float half = 1) {
  return {.id = id,
          .mesh = Quad({-half, -half, z}, {2 * half, 0, 0}, {0, 2 * half, 0}),
          .color = color};
}

class ThinRendererTest : public SoftwareContextTest {
 protected:
  void SetUp() override {
    SoftwareContextTest::SetUp();
    auto renderer = ThinRenderer::Create(*context_);
    ASSERT_TRUE(renderer.ok()) << renderer.status();
    renderer_ = *std::move(renderer);
  }

  Picture Render(const SceneDelta& delta, const RenderOptions& options = kSquare,
                 const Camera& camera = kFront) {
    const auto picture = renderer_->Render(*context_, *SceneOf(delta), {}, camera, options);
    EXPECT_TRUE(picture.ok()) << picture.status();
    return picture.ok() ? *picture
                        : Picture{.width = 64, .height = 64, .pixels = std::vector<Vec4>(64 * 64)};
  }

  absl::Status Refusal(const Camera& camera, const RenderOptions& options) {
    return renderer_->Render(*context_, *SceneOf({}), {}, camera, options).status();
  }

  std::unique_ptr<ThinRenderer> renderer_;
};

TEST_F(ThinRendererTest, AnEmptySceneIsAllBackground) {
  const Picture picture = Render({});
  EXPECT_EQ(picture.width, 64);
  EXPECT_THAT(picture.pixels, testing::Each(Vec4(0)));
}

TEST_F(ThinRendererTest, TheViewIsUprightAndNotMirrored) {
  Instance card = Card("card", Vec3(0.5f), 0, 0.25f);
  card.world_from_mesh[3] = Vec3(-0.5f, 0.75f, 0);  // left and up
  const Picture picture = Render({.upsert_instances = {card}});
  EXPECT_EQ(picture.At(16, 8), Vec4(0.5f, 0.5f, 0.5f, 1));
  EXPECT_EQ(picture.At(48, 8), Vec4(0));
  EXPECT_EQ(picture.At(16, 56), Vec4(0));
}

TEST_F(ThinRendererTest, NearerHidesFartherInWhateverOrder) {
  for (const auto& [first, second] : {std::pair{0.0f, 1.0f}, std::pair{1.0f, 0.0f}}) {
    const Picture picture = Render(
        {.upsert_instances = {Card("a", Vec3(1, 0, 0), first), Card("b", Vec3(0, 1, 0), second)}});
    EXPECT_EQ(picture.At(32, 32), first > second ? Vec4(1, 0, 0, 1) : Vec4(0, 1, 0, 1));
  }
}

TEST_F(ThinRendererTest, EdgesAreSmooth) {
  RenderOptions options = kSquare;
  options.samples_per_side = 2;
  Instance card = Card("card", Vec3(1), 0, 0.5f);
  card.world_from_mesh[0] = Vec3(0.9f, 0.4f, 0);
  card.world_from_mesh[1] = Vec3(-0.4f, 0.9f, 0);
  const Picture picture = Render({.upsert_instances = {card}}, options);
  double covered = 0;
  int partly = 0;
  for (const Vec4& pixel : picture.pixels) {
    covered += pixel.w;
    partly += pixel.w > 0 && pixel.w < 1;
    EXPECT_FLOAT_EQ(pixel.x, pixel.w) << "colour is premultiplied";
  }
  EXPECT_GT(partly, 60) << "pixels along the card's outline";
  // The card's area of 0.97 of the picture's 4: the matrix has determinant 0.97.
  EXPECT_NEAR(covered / (64 * 64), 0.97 / 4, 1e-3);
}

TEST_F(ThinRendererTest, AlphaMaskCutsAtTheNearestTexel) {
  // Row 0 lies at v = 0, the lower edge of the card.
  auto mask = AlphaMask::Create(4, 2, {255, 0, 200, 100, 0, 255, 128, 127});
  ASSERT_TRUE(mask.ok()) << mask.status();
  Instance card = Card("card", Vec3(0.5f));
  card.alpha_mask = *mask;
  card.alpha_cutoff = 0.5f;
  const Picture picture = Render({.upsert_instances = {card}});
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      const Vec2 uv((x + 0.5f) / 64, (63.5f - y) / 64);
      ASSERT_EQ(picture.At(x, y).w, (*mask)->At(uv) >= 0.5f ? 1.0f : 0.0f) << x << ", " << y;
    }
  }
}

TEST_F(ThinRendererTest, AlphaMaskRepeats) {
  auto mask = AlphaMask::Create(2, 1, {255, 0});
  ASSERT_TRUE(mask.ok()) << mask.status();
  MeshGeometry geometry = Card("card", Vec3(1)).mesh->geometry();
  geometry.uvs = {{-1, 0}, {1, 0}, {1, 1}, {-1, 1}};
  Instance card = Card("card", Vec3(0.5f));
  card.mesh = *Mesh::Create(geometry);
  card.alpha_mask = *mask;
  const Picture picture = Render({.upsert_instances = {card}});
  EXPECT_EQ(picture.At(8, 32).w, 1);
  EXPECT_EQ(picture.At(24, 32).w, 0);
  EXPECT_EQ(picture.At(40, 32).w, 1);
  EXPECT_EQ(picture.At(56, 32).w, 0);
}

// A receiver, an instance and a glowing light in one plane, seen at a grazing angle from near and
// far.
TEST_F(ThinRendererTest, SurfacesInOnePlaneDoNotFight) {
  const Instance rug = {
      .id = "rug", .mesh = Quad({-40, 0, 40}, {80, 0, 0}, {0, 0, -80}), .color = Vec3(1, 0, 0)};
  const Receiver receiver = {.id = "floor",
                             .shape = Parallelogram{.origin = {-61.3f, 0, 52.7f},
                                                    .edge_u = {120.1f, 0, 3},
                                                    .edge_v = {-2, 0, -111}},
                             .width = 4,
                             .height = 4,
                             .reflectance = Vec3(0, 1, 0)};
  const AreaLight panel = {.id = "panel",
                           .shape = RectangleLight{.corner = {-3, 0, -3},
                                                   .edge_u = {6, 0, 0},
                                                   .edge_v = {0, 0, 6},
                                                   .radiance = Vec3(0, 0, 1)}};
  for (const float height : {0.3f, 3.0f, 30.0f, 3000.0f}) {
    SCOPED_TRACE(height);
    const Camera camera = {.eye = {0, height, 39}, .target = {0, 0, 0}, .fov_y_deg = 30};
    const Picture picture = Render(
        {.upsert_instances = {rug}, .upsert_lights = {panel}, .upsert_receivers = {receiver}},
        kSquare, camera);
    int wrong = 0, glowing = 0;
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 64; ++x) {
        const Vec4& pixel = picture.At(x, y);
        glowing += pixel.z > 0.5f;
        const Vec3 p = HitPlane(camera, picture, x, y, Vec3(0), Vec3(0, 1, 0));
        const bool is_seen = glm::dot(p - camera.eye, camera.target - camera.eye) > 0;
        // Well inside the panel, well inside the rug but off the panel.
        if (!is_seen || std::max(std::abs(p.x), std::abs(p.z)) > 36) continue;
        if (std::max(std::abs(p.x), std::abs(p.z)) < 2) wrong += pixel.z < 0.99f;
        if (std::max(std::abs(p.x), std::abs(p.z)) > 5) wrong += pixel.y > 0.01f || pixel.z > 0.01f;
      }
    }
    EXPECT_EQ(wrong, 0);
    if (height == 3.0f || height == 30.0f) {
      EXPECT_GT(glowing, 0);
    }
  }
}

TEST_F(ThinRendererTest, AReceiverThatAnInstanceFillsIsNotDrawnTwice) {
  auto holes = AlphaMask::Create(2, 1, {255, 0});
  ASSERT_TRUE(holes.ok()) << holes.status();
  Instance card = Card("card", Vec3(0.5f));
  card.alpha_mask = *holes;
  Receiver receiver = {
      .id = "patch",
      .shape = Parallelogram{.origin = {-1, -1, 0}, .edge_u = {2, 0, 0}, .edge_v = {0, 2, 0}},
      .width = 4,
      .height = 4};
  EXPECT_EQ(Render({.upsert_instances = {card}, .upsert_receivers = {receiver}}).At(48, 32).w, 0)
      << "the hole shows what is behind";
  receiver.shape =
      Parallelogram{.origin = {-1, -1, -0.5f}, .edge_u = {2, 0, 0}, .edge_v = {0, 2, 0}};
  EXPECT_EQ(Render({.upsert_instances = {card}, .upsert_receivers = {receiver}}).At(48, 32).w, 1);
}

TEST_F(ThinRendererTest, LightsGlowFromTheSideTheyShineFrom) {
  const Vec3 radiance(7, 5, 3);
  const auto rectangle = [&](bool faces_us, bool two_sided) {
    return AreaLight{.id = "l",
                     .shape = RectangleLight{.corner = {-0.5f, -0.5f, 0},
                                             .edge_u = faces_us ? Vec3(1, 0, 0) : Vec3(0, 1, 0),
                                             .edge_v = faces_us ? Vec3(0, 1, 0) : Vec3(1, 0, 0),
                                             .radiance = radiance,
                                             .two_sided = two_sided}};
  };
  const Vec4 glow(radiance, 1);
  EXPECT_EQ(Render({.upsert_lights = {rectangle(true, false)}}).At(32, 32), glow);
  EXPECT_EQ(Render({.upsert_lights = {rectangle(false, false)}}).At(32, 32), Vec4(0));
  EXPECT_EQ(Render({.upsert_lights = {rectangle(false, true)}}).At(32, 32), glow);
  const AreaLight disk = {
      .id = "l",
      .shape =
          DiskLight{.normal = {0, 0, 2}, .radius = 0.5f, .radiance = radiance, .two_sided = false}};
  const Picture round = Render({.upsert_lights = {disk}});
  EXPECT_EQ(round.At(32, 32), glow);
  EXPECT_EQ(round.At(32 + 12, 32 + 12), Vec4(0)) << "outside the disc, inside its square";
  const AreaLight sphere = {.id = "l", .shape = SphereLight{.radius = 0.5f, .radiance = radiance}};
  EXPECT_EQ(Render({.upsert_lights = {sphere}}).At(32, 18), glow);
  RenderOptions without = kSquare;
  without.draws_lights = false;
  EXPECT_EQ(Render({.upsert_lights = {sphere}}, without).At(32, 32), Vec4(0));
}

TEST_F(ThinRendererTest, RadianceIsCutBeforeItIsAveraged) {
  const AreaLight sphere = {.id = "l", .shape = SphereLight{.radius = 0.5f, .radiance = Vec3(100)}};
  RenderOptions options = kSquare;
  options.clip_radiance = 2;
  for (const Vec4& pixel : Render({.upsert_lights = {sphere}}, options).pixels) {
    ASSERT_FLOAT_EQ(pixel.x, 2 * pixel.w);
  }
}

TEST_F(ThinRendererTest, BackFacesAreLeftOutOnlyWhenAsked) {
  Instance card = Card("card", Vec3(0.5f));
  card.world_from_mesh[0] = Vec3(-1, 0, 0);  // a mirror turns the face away
  EXPECT_EQ(Render({.upsert_instances = {card}}).At(32, 32).w, 1);
  RenderOptions options = kSquare;
  options.culls_back_faces = true;
  EXPECT_EQ(Render({.upsert_instances = {card}}, options).At(32, 32).w, 0);
}

TEST_F(ThinRendererTest, OddGeometryDrawsNothingAndHarmsNothing) {
  Instance flat = Card("flat", Vec3(1));
  flat.world_from_mesh = Affine(Vec3(0), Vec3(0), Vec3(0), Vec3(0));
  Instance empty = Card("empty", Vec3(1));
  empty.mesh = *Mesh::Create({});
  Instance degenerate = Card("degenerate", Vec3(1));
  degenerate.mesh = *Mesh::Create({.positions = {{0, 0, 1}, {1, 0, 1}, {0, 0, 1}},
                                   .indices = {0, 1, 2},
                                   .normals = {},
                                   .uvs = {}});
  const Picture picture =
      Render({.upsert_instances = {flat, empty, degenerate, Card("z", Vec3(0.5f))}});
  EXPECT_THAT(picture.pixels, testing::Each(Vec4(0.5f, 0.5f, 0.5f, 1)));
}

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
  auto fresh = gl::Context::Create({.device = "software"});
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
