#include "render/light_view/view_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "tests/support/random_scene.h"

namespace penumbra {
namespace {

using testing::Dice;

struct Views {
  LightFace face;
  std::vector<LightView> of_samples;
};

// Views of random boxes from random lights.
std::vector<Views> RandomViews(uint64_t seed) {
  Dice dice(seed);
  const AreaLight light = testing::RandomLight(dice, static_cast<int>(seed % 6));
  Aabb box;
  box.Add(dice.InCube(3));
  box.Add(dice.InCube(3));
  std::vector<Views> all;
  for (const LightFace& face : FacesOf(light, box)) {
    Views views{.face = face};
    const double pitch = std::max(face.window.size().x, face.window.size().y) / 100;
    for (const LightSample& sample : SampleLight(light, 9, seed, box.center())) {
      if (const auto view = ViewFrom(face, sample, std::array{box}, pitch)) {
        views.of_samples.push_back(*view);
      }
    }
    all.push_back(std::move(views));
  }
  return all;
}

TEST(LightViewTest, PointAtIsTheInverseOfProject) {
  for (uint64_t seed = 0; seed < 120; ++seed) {
    Dice dice(1000 + seed);
    for (const Views& views : RandomViews(seed)) {
      for (const LightView& view : views.of_samples) {
        const DVec2 pixel(dice.Between(0, static_cast<float>(view.width)),
                          dice.Between(0, static_cast<float>(view.height)));
        const double depth = view.from_infinity ? dice.Between(-3, 3) : dice.Between(0.1f, 5);
        const DVec3 again = view.Project(view.PointAt(pixel, depth));
        EXPECT_NEAR(again.x, pixel.x, 1e-6 * view.width);
        EXPECT_NEAR(again.y, pixel.y, 1e-6 * view.height);
        EXPECT_NEAR(again.z, depth, 1e-9);
      }
    }
  }
}

// Points on the segment from the eye, or along its direction, fall on one pixel.
TEST(LightViewTest, WhatIsInLineWithTheSampleFallsOnOnePixel) {
  for (uint64_t seed = 0; seed < 120; ++seed) {
    Dice dice(seed);
    const AreaLight light = testing::RandomLight(dice, static_cast<int>(seed % 6));
    Aabb box;
    box.Add(dice.InCube(3));
    box.Add(dice.InCube(3));
    for (const LightFace& face : FacesOf(light, box)) {
      for (const LightSample& sample : SampleLight(light, 4, seed, box.center())) {
        const auto view = ViewFrom(face, sample, std::array{box}, 0.01);
        if (!view) continue;
        const DVec3 p = view->PointAt(DVec2(3.5, 7.5), view->far);
        const DVec3 to_light = sample.at_infinity ? DVec3(sample.point) : DVec3(sample.point) - p;
        const DVec3 moved = view->Project(p + 0.25 * to_light);
        EXPECT_NEAR(moved.x, 3.5, 1e-3) << seed;
        EXPECT_NEAR(moved.y, 7.5, 1e-3) << seed;
        EXPECT_LT(moved.z, view->far);
      }
    }
  }
}

// Agrawala et al. 2000, equation (3): what moves between two views of a planar light moves by the
// distance between their eyes over the depth, which is the same in both.
TEST(LightViewTest, ViewsOfAPlanarLightDifferByTheDisparity) {
  const AreaLight light{.id = "lamp", .shape = RectangleLight{.corner = {-0.5f, 3, -0.5f}}};
  const Aabb box{.min = {-2, 0, -1}, .max = {1, 2, 1}};
  const auto faces = FacesOf(light, box);
  ASSERT_EQ(faces.size(), 1u);
  const double pitch = 0.01;
  const auto center = CenterView(faces[0], std::array{box}, pitch);
  ASSERT_TRUE(center.has_value());
  Dice dice(7);
  for (const LightSample& sample : SampleLight(light, 64, 1, Vec3(0))) {
    const auto view = ViewFrom(faces[0], sample, std::array{box}, pitch);
    ASSERT_TRUE(view.has_value());
    const DVec3 p(dice.Between(-2, 1), dice.Between(0, 2), dice.Between(-1, 1));
    const DVec3 a = view->Project(p), b = center->Project(p);
    EXPECT_NEAR(a.z, b.z, 1e-6);
    const DVec3 dv = faces[0].frame.FromWorld(DVec3(sample.point));
    const DVec2 windows = (view->window.min - center->window.min) / pitch;
    EXPECT_NEAR(b.x - a.x, dv.x / b.z / pitch + windows.x, 1e-4);
    EXPECT_NEAR(b.y - a.y, dv.y / b.z / pitch + windows.y, 1e-4);
  }
}

TEST(LightViewTest, AllOfTheBoxesIsInTheImageAndBetweenItsDepths) {
  for (uint64_t seed = 0; seed < 120; ++seed) {
    Dice dice(seed);
    const AreaLight light{.id = "lamp", .shape = RectangleLight{.corner = {-0.5f, 5, -0.5f}}};
    std::vector<Aabb> boxes(3);
    Aabb all;
    for (Aabb& box : boxes) {
      box.Add(dice.InCube(2));
      box.Add(dice.InCube(2));
      all.Add(box);
    }
    for (const LightFace& face : FacesOf(light, all)) {
      for (const LightSample& sample : SampleLight(light, 4, seed, Vec3(0))) {
        const auto view = ViewFrom(face, sample, boxes, 0.02);
        ASSERT_TRUE(view.has_value());
        for (int i = 0; i < 24; ++i) {
          const DVec3 p = view->Project(CornerOf(boxes[i / 8], i % 8));
          EXPECT_GE(p.x, -1e-6);
          EXPECT_LE(p.x, view->width + 1e-6);
          EXPECT_GE(p.y, -1e-6);
          EXPECT_LE(p.y, view->height + 1e-6);
          EXPECT_GE(p.z, view->near - 1e-9);
          EXPECT_LE(p.z, view->far + 1e-9);
        }
      }
    }
  }
}

// A light as large as the scene, or larger: what its middle sees, each of its samples sees.
TEST(LightViewTest, LargeLightsSeeAllFromEachSample) {
  const Aabb box{.min = {-1, 0, -1}, .max = {1, 2, 1}};
  for (const float side : {1.0f, 4.0f, 20.0f}) {
    const RectangleLight lamp{.corner = 0.5f * side * Vec3(-1, 0, -1) + Vec3(0, side + 3, 0),
                              .edge_u = {side, 0, 0},
                              .edge_v = {0, 0, side}};
    const SphereLight globe{.center = {0, side + 3, 0}, .radius = 0.5f * side};
    for (const AreaLight& light : {AreaLight{"lamp", lamp}, AreaLight{"globe", globe}}) {
      const auto faces = FacesOf(light, box);
      ASSERT_EQ(faces.size(), 1u);
      for (const LightSample& sample : SampleLight(light, 16, 1, box.center())) {
        const auto view = ViewFrom(faces[0], sample, std::array{box}, 0.01);
        ASSERT_TRUE(view.has_value());
        for (int i = 0; i < 8; ++i) {
          const DVec3 p = view->Project(CornerOf(box, i));
          EXPECT_TRUE(p.x >= -1e-6 && p.x <= view->width + 1e-6) << p.x << " of " << view->width;
          EXPECT_TRUE(p.y >= -1e-6 && p.y <= view->height + 1e-6) << p.y;
        }
      }
    }
  }
}

TEST(LightViewTest, NoViewIsWiderThanThreeWindows) {
  // A light in the middle of things.
  const AreaLight light{.id = "lamp", .shape = RectangleLight{.corner = {-0.5f, 0, -0.5f}}};
  const Aabb box{.min = {-20, -20, -20}, .max = {20, 20, 20}};
  for (const LightFace& face : FacesOf(light, box)) {
    for (const LightSample& sample : SampleLight(light, 16, 1, Vec3(0))) {
      const auto view = ViewFrom(face, sample, std::array{box}, 0.01);
      ASSERT_TRUE(view.has_value());
      EXPECT_LE(view->window.size().x, 3 * face.window.size().x + 0.02);
      EXPECT_LE(view->window.size().y, 3 * face.window.size().y + 0.02);
      EXPECT_GT(view->near, 0);
      if (face.frame.axes.n.y == 0) continue;
      // What is half a metre before the light, in the window, is seen.
      const DVec3 eye = face.frame.FromWorld(DVec3(sample.point));
      for (const DVec2 w : {face.window.min, face.window.max}) {
        const DVec2 slope = w - DVec2(eye) / 0.5;
        EXPECT_TRUE(glm::all(glm::greaterThanEqual(slope, view->window.min - 1e-9)));
        EXPECT_TRUE(glm::all(glm::lessThanEqual(slope, view->window.max + 1e-9)));
      }
    }
  }
}

// All that the face sees is close to some of the globe's samples, or behind them.
TEST(LightViewTest, NorIsOneFromCloseBy) {
  const AreaLight globe{.id = "globe", .shape = SphereLight{.center = {0, 4, 0}, .radius = 1}};
  const Aabb box{.min = {0.70f, 3.249f, -0.1f}, .max = {0.74f, 3.25f, 0.1f}};
  int seen = 0;
  for (const LightFace& face : FacesOf(globe, box)) {
    for (const LightSample& sample : SampleLight(globe, 100, 1, box.center())) {
      const auto view = ViewFrom(face, sample, std::array{box}, 0.01);
      if (!view) continue;
      EXPECT_LE(view->window.size().x, 3 * face.window.size().x + 0.02);
      EXPECT_LE(view->window.size().y, 3 * face.window.size().y + 0.02);
      ++seen;
    }
  }
  EXPECT_GT(seen, 50);
}

// Its pixels are the view's own, and no corner of the box is beyond them.
TEST(LightViewTest, PartsHoldTheBoxAndKeepThePixels) {
  int smaller = 0;
  for (uint64_t seed = 0; seed < 120; ++seed) {
    Dice dice(seed);
    const AreaLight light = testing::RandomLight(dice, static_cast<int>(seed % 6));
    Aabb all, box;
    for (int i = 0; i < 4; ++i) all.Add(dice.InCube(3));
    for (int i = 0; i < 2; ++i) box.Add(0.3f * dice.InCube(3));
    for (const LightFace& face : FacesOf(light, all)) {
      const auto view = CenterView(face, std::array{all}, 0.01);
      if (!view) continue;
      const auto part = PartOf(*view, box);
      for (int i = 0; i < 8; ++i) {
        const DVec3 p = view->Project(CornerOf(box, i));
        const bool is_seen = (view->from_infinity || p.z > 0) && p.x > 0 && p.y > 0 &&
                             p.x < view->width && p.y < view->height;
        if (!is_seen) continue;
        ASSERT_TRUE(part) << seed;
        const DVec3 q = part->Project(CornerOf(box, i));
        EXPECT_TRUE(q.x > 0 && q.y > 0 && q.x < part->width && q.y < part->height) << seed;
        const DVec2 apart = DVec2(p) - DVec2(q);
        EXPECT_NEAR(apart.x, std::round(apart.x), 1e-6) << seed;
        EXPECT_NEAR(apart.y, std::round(apart.y), 1e-6) << seed;
      }
      smaller += !part || part->width < view->width || part->height < view->height;
    }
    EXPECT_FALSE(PartOf(LightView{}, box));
  }
  EXPECT_GT(smaller, 30);
}

TEST(LightViewTest, ThereIsNoViewOfNothingAndNoneTooLarge) {
  const AreaLight light{.id = "lamp", .shape = RectangleLight{.corner = {-0.5f, 3, -0.5f}}};
  const Aabb box{.min = {-1, 0, -1}, .max = {1, 1, 1}};
  const LightFace face = FacesOf(light, box).at(0);
  const LightSample sample = SampleLight(light, 1, 1, Vec3(0)).at(0);
  EXPECT_FALSE(ViewFrom(face, sample, {}, 0.01));
  EXPECT_FALSE(ViewFrom(face, sample, std::array{Aabb{}}, 0.01));
  const Aabb behind{.min = {-1, 4, -1}, .max = {1, 5, 1}};
  EXPECT_FALSE(ViewFrom(face, sample, std::array{behind}, 0.01));
  for (const double pitch : {0.0, -1.0, std::nan("")}) {
    EXPECT_FALSE(ViewFrom(face, sample, std::array{box}, pitch)) << pitch;
  }
  const auto finest = ViewFrom(face, sample, std::array{box}, 1e-12);
  ASSERT_TRUE(finest.has_value());
  EXPECT_EQ(finest->width, kMaxViewSide);
  EXPECT_EQ(finest->height, kMaxViewSide);
  const auto fine = ViewFrom(face, sample, std::array{box}, 1e-3);
  ASSERT_TRUE(fine.has_value());
  EXPECT_NEAR(finest->window.size().x, fine->window.size().x, 1e-3) << "nothing is cut";
  const auto coarsest = ViewFrom(face, sample, std::array{box}, 1e6);
  ASSERT_TRUE(coarsest.has_value());
  EXPECT_EQ(coarsest->width, 1u);
  EXPECT_EQ(coarsest->height, 1u);
}

}  // namespace
}  // namespace penumbra
