// Caps against what is in shadow on the near plane, and caps with the whole boundary against what
// is in shadow anywhere, point by point.
#include "render/artifact/volume_cap.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <vector>

#include "render/technique/shadow_volume/template_mesh.h"
#include "tests/support/volume_crossings.h"
#include "tests/unit/shadow_volume/depth_maps.h"

namespace penumbra {
namespace {

using testing::Dice;
using testing::EyeImage;
using testing::MapOf;
using testing::RandomMap;
using testing::SomeView;
using testing::VolumeCrossings;

constexpr uint32_t kSide = 48;  // pixels of the eye

// The whole boundary of a map, whose light it is.
ShadowVolumeMesh WholeMesh(const DepthMap& map) {
  ShadowVolumeMesh mesh{.light = {.id = "light", .shape = PointLight{}}, .bias_px = 0.5f};
  const LightView& view = map.view;
  if (view.from_infinity) {
    const DVec3 away = view.PointAt(DVec2(1), 1) - view.PointAt(DVec2(1), 0);
    mesh.light.shape = DistantLight{.to_light = Vec3(-away)};
  } else {
    mesh.light.shape = PointLight{.position = Vec3(view.frame.ToWorld(view.eye))};
  }
  const VolumeGrid grid(map, VolumeBorder::kNothing, mesh.bias_px);
  VolumeTriangles triangles;
  AddTriangles(grid, EdgeMap(grid), Reconstruction::kAllCells, triangles);
  mesh.volumes.push_back(
      std::make_shared<ShadowVolume>(ShadowVolume{.faces = {{.map = map}},
                                                  .vertices = std::move(triangles.vertices),
                                                  .indices = std::move(triangles.indices)}));
  return mesh;
}

// An origin that single precision holds.
LightView ViewForCaps(bool from_infinity) {
  LightView view = SomeView(9, 8, from_infinity);
  view.frame.origin = DVec3(0.25, 5, -0.75);
  return view;
}

EyeImage EyeAt(DVec3 eye, DVec3 target, double near) {
  const DMat4 view = glm::lookAt(eye, target, DVec3(0.1, 0.9, 0.3));
  return {.clip_from_world = glm::perspective(1.2, 1.0, near, 100.0) * view,
          .width = kSide,
          .height = kSide,
          .near = near};
}

EyeImage RandomEye(Dice& dice, const LightView& view) {
  const auto place = [&] {
    const DVec2 pixel(dice.Between(-1, 10), dice.Between(-1, 9));
    return view.PointAt(pixel, dice.Between(0.3f, 10));
  };
  const DVec3 eye = place();
  // Now and then straight towards the light or away from it.
  const DVec3 light = view.frame.origin;
  const uint32_t kind = dice.Below(4);
  const DVec3 target = kind == 0 ? light : kind == 1 ? 2.0 * eye - light : place();
  return EyeAt(eye, target, dice.Between(0.05f, 3));
}

// What a pixel's ray passes at a depth along the view.
DVec3 PointAt(const EyeImage& eye, size_t pixel, double depth) {
  const double x = 2 * (static_cast<double>(pixel % eye.width) + 0.5) / eye.width - 1;
  const double y = 2 * (static_cast<double>(pixel / eye.width) + 0.5) / eye.height - 1;
  const DMat4 world_from_clip = glm::inverse(eye.clip_from_world);
  const DVec4 p0 = world_from_clip * DVec4(x, y, -1, 1), p1 = world_from_clip * DVec4(x, y, 1, 1);
  const DVec3 a = DVec3(p0) / p0.w, b = DVec3(p1) / p1.w;
  const auto depth_of = [&](DVec3 p) { return (eye.clip_from_world * DVec4(p, 1)).w; };
  const double t = (depth - depth_of(a)) / (depth_of(b) - depth_of(a));
  return glm::mix(a, b, t);
}

size_t WrongOnNearPlane(const ShadowVolumeMesh& mesh, const EyeImage& eye, size_t& in_shadow) {
  const VolumeCaps caps = VolumeCapper(*mesh.volumes[0], mesh.bias_px, mesh.light)
                              .CapsFor(eye.clip_from_world, eye.near);
  VolumeCrossings crossings(eye, std::vector<double>(kSide * kSide, 0.0));
  crossings.AddCaps(caps.corners);
  if (caps.inverts) crossings.Invert();
  const VolumeLookup lookup(mesh);
  size_t wrong = 0;
  for (size_t pixel = 0; pixel < kSide * kSide; ++pixel) {
    const bool expected = lookup.Depth(PointAt(eye, pixel, eye.near)) > 0;
    in_shadow += expected;
    wrong += crossings.IsOdd(pixel) != expected || crossings.Count(pixel) != int{expected};
  }
  return wrong;
}

TEST(VolumeCapTest, CapsAreWhatIsInShadowOnTheNearPlane) {
  Dice dice(21);
  size_t in_shadow = 0, wrong = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const LightView view = ViewForCaps(trial % 2);
    const ShadowVolumeMesh mesh = WholeMesh(RandomMap(dice, view, 0.1f));
    const size_t here = WrongOnNearPlane(mesh, RandomEye(dice, view), in_shadow);
    EXPECT_LE(here, 3u) << trial;
    wrong += here;
  }
  EXPECT_GT(in_shadow, 20u * kSide * kSide);
  EXPECT_LE(wrong, 5u);  // of 460,800: rounding to single precision
}

// The proof of the whole: from anywhere, to any depth, one bit says what is in shadow.
TEST(VolumeCapTest, OneBitIsEnoughForAnyRay) {
  Dice dice(22);
  size_t wrong = 0, in_shadow = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const LightView view = ViewForCaps(trial % 2);
    const ShadowVolumeMesh mesh = WholeMesh(RandomMap(dice, view, 0.1f));
    const EyeImage eye = RandomEye(dice, view);
    std::vector<double> inverse(kSide * kSide);
    for (double& i : inverse) i = 1 / (eye.near + dice.Between(0, 8));
    VolumeCrossings crossings(eye, inverse);
    crossings.Add(mesh.volumes[0]->vertices, mesh.volumes[0]->indices);
    const VolumeCaps caps = VolumeCapper(*mesh.volumes[0], mesh.bias_px, mesh.light)
                                .CapsFor(eye.clip_from_world, eye.near);
    crossings.AddCaps(caps.corners);
    if (caps.inverts) crossings.Invert();
    const VolumeLookup lookup(mesh);
    size_t here = 0;
    for (size_t pixel = 0; pixel < inverse.size(); ++pixel) {
      const bool expected = lookup.Depth(PointAt(eye, pixel, 1 / inverse[pixel])) > 0;
      in_shadow += expected;
      here += crossings.IsOdd(pixel) != expected || crossings.Count(pixel) != int{expected};
    }
    EXPECT_LE(here, 4u) << trial;
    wrong += here;
  }
  EXPECT_GT(in_shadow, 20u * kSide * kSide);
  EXPECT_LE(wrong, 5u);
}

// All 32: which corners of a cell are before the plane, and how it is split.
TEST(VolumeCapTest, EveryCaseOfACellIsRight) {
  for (int split = 0; split < 2; ++split) {
    for (int before = 0; before < 16; ++before) {
      LightView view = ViewForCaps(false);
      view.width = view.height = 2;
      // The plane is at depth 3; a cell is split across the greater difference.
      const float near_depths[] = {2.0f, 2.4f}, far_depths[] = {4.0f, 6.0f};
      const DepthMap map = MapOf(view, [&](uint32_t x, uint32_t y) {
        const uint32_t corner = y == 0 ? x : 3 - x;
        const bool odd = corner % 2 == static_cast<uint32_t>(split);
        return (before >> corner & 1) ? near_depths[odd ? 0 : 1] : far_depths[odd ? 1 : 0];
      });
      const ShadowVolumeMesh mesh = WholeMesh(map);
      const DVec3 middle = view.PointAt(DVec2(1, 1), 2.5), light = view.frame.origin;
      const double depth = glm::dot(middle - light, view.frame.axes.n);
      ASSERT_NEAR(depth, 2.5, 1e-9);
      const EyeImage eye =
          EyeAt(light + 1.0 * view.frame.axes.n, light + 2.0 * view.frame.axes.n, 2);
      size_t in_shadow = 0;
      EXPECT_LE(WrongOnNearPlane(mesh, eye, in_shadow), 2u) << split << " " << before;
      EXPECT_EQ(in_shadow > 0, before != 0) << split << " " << before;
    }
  }
}

TEST(VolumeCapTest, AllInShadowIsInvertedWithoutTriangles) {
  LightView view = ViewForCaps(false);
  view.width = view.height = 64;
  const ShadowVolumeMesh mesh = WholeMesh(MapOf(view, [](uint32_t, uint32_t) { return 2.0f; }));
  const DVec3 below = view.PointAt(DVec2(32), 6);
  for (const DVec3 way : {view.frame.axes.n, -view.frame.axes.n, view.frame.axes.s}) {
    const EyeImage eye = EyeAt(below, below + way, 0.05);
    const VolumeCaps caps =
        VolumeCapper(*mesh.volumes[0], mesh.bias_px, mesh.light).CapsFor(eye.clip_from_world, 0.05);
    EXPECT_TRUE(caps.inverts);
    EXPECT_EQ(caps.triangle_count(), 0u);
    EXPECT_GT(caps.tested_samples, 0u);
  }
  const DVec3 above = view.PointAt(DVec2(32), 1);
  const EyeImage eye = EyeAt(above, above + view.frame.axes.n, 0.05);
  const VolumeCaps none =
      VolumeCapper(*mesh.volumes[0], mesh.bias_px, mesh.light).CapsFor(eye.clip_from_world, 0.05);
  EXPECT_FALSE(none.inverts);
  EXPECT_EQ(none.triangle_count(), 0u);
}

// A near plane that holds the light: shadows on it are those beside the plane.
TEST(VolumeCapTest, LightInTheNearPlane) {
  Dice dice(23);
  size_t wrong = 0, in_shadow = 0;
  for (int trial = 0; trial < 20; ++trial) {
    const LightView view = ViewForCaps(false);
    const ShadowVolumeMesh mesh = WholeMesh(RandomMap(dice, view, 0.0f));
    const DVec3 light = view.frame.origin, n = view.frame.axes.n, s = view.frame.axes.s;
    // Looks along s, so that the plane at 1 m goes through the light; the eye is below the light.
    const DVec3 eye_place =
        light - s + 3.0 * n + double{dice.Between(-0.3f, 0.3f)} * view.frame.axes.t;
    const EyeImage eye = EyeAt(eye_place, eye_place + s, 1.0);
    wrong += WrongOnNearPlane(mesh, eye, in_shadow);
  }
  EXPECT_GT(in_shadow, 1000u);
  EXPECT_LT(wrong, in_shadow / 100);
}

TEST(VolumeCapTest, NothingHasNoCaps) {
  const EyeImage eye = EyeAt(DVec3(0), DVec3(1, 0, 0), 0.1);
  const ShadowVolume empty;
  const AreaLight light{.id = "light", .shape = PointLight{}};
  const VolumeCaps caps = VolumeCapper(empty, 1, light).CapsFor(eye.clip_from_world, 0.1);
  EXPECT_FALSE(caps.inverts);
  EXPECT_TRUE(caps.corners.empty());
  ShadowVolume nothing{.faces = {{.map = MapOf(SomeView(5, 5, false),
                                               [](uint32_t, uint32_t) { return kNoDepth; })}}};
  EXPECT_TRUE(VolumeCapper(nothing, 1, light).CapsFor(eye.clip_from_world, 0.1).corners.empty());
}

}  // namespace
}  // namespace penumbra
