// What the thin renderer draws where.
#include "client/display/thin_renderer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tests/gl/display/small_scenes.h"
#include "tests/gl/display/thin_renderer_fixture.h"

namespace penumbra {
namespace {

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

}  // namespace
}  // namespace penumbra
