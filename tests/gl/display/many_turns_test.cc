// Row A19 of the catalogue in the thin renderer: more to look through than loops of shaders may
// have turns. llvmpipe ends them at 65,535, and leaves out the rest without a word.
#include <gtest/gtest.h>

#include <cmath>

#include "absl/strings/str_cat.h"
#include "client/display/light_ranges.h"
#include "render/scene/unoccluded_light.h"
#include "tests/gl/display/thin_renderer_fixture.h"
#include "tests/support/random_ldi.h"

namespace penumbra {
namespace {

constexpr uint32_t kSamples = 4;
constexpr int kLights = 1024;

std::string LightId(int l) { return absl::StrCat("light", 1000 + l); }
std::string CellId(int x, int y) { return absl::StrCat("cell", 100 * y + x); }
uint32_t VisibleOf(int l, int x, int y) { return static_cast<uint32_t>(l + 3 * x + y) % 4 + 1; }

// Each in a place of its own before the card, and of the same strength, so that each counts.
AreaLight Bulb(int l) {
  return {.id = LightId(l),
          .shape = PointLight{.position = {std::sin(1.0f * l), std::cos(2.0f * l), 2 + 1e-3f * l},
                              .intensity = Vec3(1e-2f)}};
}

// A card of one triangle, larger than the picture.
Instance Wall() {
  MeshGeometry triangle;
  triangle.positions = {{-1, -1, 0}, {3, -1, 0}, {-1, 3, 0}};
  triangle.indices = {0, 1, 2};
  return {.id = "card", .mesh = *Mesh::Create(std::move(triangle)), .color = Vec3(1)};
}

// Leans so that every point of the card sees a part of it above its horizon.
AreaLight Disk(int l) {
  return {.id = LightId(l),
          .shape = DiskLight{.center = {std::sin(1.0f * l), std::cos(2.0f * l), 0.05f},
                             .normal = {0.3f * std::sin(3.0f * l), 1, -0.2f},
                             .radius = 0.2f,
                             .radiance = Vec3(1e-2f)}};
}

class ManyTurnsTest : public ThinRendererTest {
 protected:
  static RenderOptions Options(int side) {
    return {.width = side, .height = side, .samples_per_side = 1, .draws_lights = false};
  }

  // That each pixel of the card shows the sum over all lights of what it gets of each.
  void ExpectSums(const Scene& scene, const std::vector<std::shared_ptr<const Artifact>>& artifacts,
                  int side, const std::function<double(int l, int x, int y)>& share) {
    const auto picture = renderer_->Render(*context_, scene, artifacts, kFront, Options(side));
    ASSERT_TRUE(picture.ok()) << picture.status();
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        // Clipping cuts the card along there: a pixel shows a point beside its centre.
        if (x + y == side - 1) continue;
        const Vec3 point = HitPlane(kFront, *picture, x, y, Vec3(0), Vec3(0, 0, 1));
        double expected = 0;
        for (size_t l = 0; l < scene.lights().size(); ++l) {
          const auto light = scene.FindLight(LightId(static_cast<int>(l)));
          expected +=
              share(static_cast<int>(l), x, y) * UnoccludedRadiance(*light, point, Vec3(0, 0, 1)).x;
        }
        // A tenth of what one of a thousand would be missed by.
        EXPECT_NEAR(picture->At(x, y).x, expected, 1e-4 * expected) << x << ", " << y;
      }
    }
  }

  // The card in side × side cells, each a receiver of one texel, by `candidates` artifacts.
  void ExpectCells(int side, size_t candidates) {
    SceneDelta delta{.upsert_instances = {Wall()}};
    for (int l = 0; l < kLights; ++l) delta.upsert_lights.push_back(Bulb(l));
    const float cell = 2.0f / side;
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        delta.upsert_receivers.push_back(
            {.id = CellId(x, y),
             .shape = Parallelogram{.origin = {-1 + cell * x, 1 - cell * (y + 1), 0},
                                    .edge_u = {cell, 0, 0},
                                    .edge_v = {0, cell, 0}},
             .width = 1,
             .height = 1});
      }
    }
    const auto scene = SceneOf(delta);
    std::vector<std::shared_ptr<const Artifact>> artifacts;
    const auto has_artifact = [&](int l, int x, int y) {
      return (size_t{1} * y * side + x) * kLights + l < candidates;
    };
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        for (int l = 0; l < kLights && has_artifact(l, x, y); ++l) {
          artifacts.push_back(ArtifactOf(*scene, LightId(l), CellId(x, y), kSamples,
                                         [&](uint32_t, uint32_t) { return VisibleOf(l, x, y); }));
        }
      }
    }
    ASSERT_EQ(artifacts.size(), candidates);
    ExpectSums(*scene, artifacts, side, [&](int l, int x, int y) {
      return has_artifact(l, x, y) ? VisibleOf(l, x, y) / (1.0 * kSamples) : 1.0;
    });
  }
};

TEST_F(ManyTurnsTest, A19OneCandidateLessThanALoopMayHaveTurns) { ExpectCells(8, 65'535); }
TEST_F(ManyTurnsTest, A19AsManyCandidatesAsOneTurnTooMany) { ExpectCells(8, 65'536); }
TEST_F(ManyTurnsTest, A19AHundredThousandCandidates) { ExpectCells(10, 100'000); }

// 96 sides each, of which the horizon cuts some.
TEST_F(ManyTurnsTest, A19SidesOfAThousandDisks) {
  SceneDelta delta{.upsert_instances = {Wall()}};
  for (int l = 0; l < kLights; ++l) delta.upsert_lights.push_back(Disk(l));
  ExpectSums(*SceneOf(delta), {}, 6, [](int, int, int) { return 1.0; });
}

// What is in front of others stays there, and what glows glows once.
TEST_F(ManyTurnsTest, SurfacesAtTheSamePlaceAndGlowsAreLitOnce) {
  SceneDelta few{.upsert_instances = {Card("behind", Vec3(0.5f)), Card("same-place", Vec3(1)),
                                      Card("front", Vec3(1), 0.5f, 0.4f)},
                 .upsert_lights = {{.id = "lamp",
                                    .shape = RectangleLight{.corner = {0.5f, 0.5f, 1},
                                                            .edge_u = {0, 0.2f, 0},
                                                            .edge_v = {0.2f, 0, 0},
                                                            .radiance = Vec3(7)}}}};
  SceneDelta many = few;
  for (int l = 0; l < 1000; ++l) {
    AreaLight dark = Disk(l);
    std::get<DiskLight>(dark.shape).radiance = Vec3(0);
    many.upsert_lights.push_back(dark);
  }
  RenderOptions options = kSquare;
  options.clip_radiance = 5;
  const Picture expected = Render(few, options), found = Render(many, options);
  ASSERT_EQ(found.pixels.size(), expected.pixels.size());
  // Sums are rounded one range later.
  for (size_t i = 0; i < found.pixels.size(); ++i) {
    EXPECT_LE(glm::length(found.pixels[i] - expected.pixels[i]), 1e-5f) << i;
  }
}

TEST(LightRangesTest, AreAllLightsOnceAndNoLongerThanTheyMayBe) {
  DrawList list;
  list.lights.resize(500);
  DrawItem item{.mesh = Quad({0, 0, 0}, {1, 0, 0}, {0, 1, 0})};
  for (uint32_t light = 100; light < 110; ++light) {
    for (uint32_t c = 0; c < 4096; ++c) list.candidates.push_back({.light = light, .receiver = c});
  }
  item.end_candidate = static_cast<uint32_t>(list.candidates.size());
  list.items.push_back(item);
  std::vector<uint32_t> order(500), turns(500, 0);
  for (uint32_t l = 0; l < 500; ++l) order[l] = l;
  turns[300] = 60'000;
  const auto ranges = LightRanges(list, order, turns, 500);
  int end = 0;
  for (const LightRange& range : ranges) {
    EXPECT_EQ(range.first, end);
    EXPECT_GT(range.end, range.first);
    end = range.end;
    const bool has_many = range.first <= 100 && range.end > 101;
    EXPECT_FALSE(has_many) << "two lights with 4,096 candidates each";
  }
  EXPECT_EQ(end, 500);
  EXPECT_EQ(LightRanges({}, {}, {}, 0).size(), 1u);
  EXPECT_EQ(SkippedCandidates(list, item, order, 103), 3u * 4096);
}

TEST(LightRangesTest, CountTheMostLayersOfAPixelOfEachFace) {
  std::mt19937 random(1);
  AttenuationLdi ldi;
  ldi.faces.push_back(RandomLdiFace(9, 9, false, 4, random));
  const uint32_t few = TurnsOf(ldi);
  EXPECT_GE(few, 4u * 4);
  // A pixel with 128.
  ldi.faces[0].offsets.push_back(ldi.faces[0].offsets.back() + 128);
  EXPECT_GE(TurnsOf(ldi), 4u * 129);
  ldi.faces.push_back(ldi.faces[0]);
  EXPECT_GE(TurnsOf(ldi), 8u * 129);
}

}  // namespace
}  // namespace penumbra
