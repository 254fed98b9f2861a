// ViewWarp against projecting points of planes, in double precision.
#include "render/technique/layered_attenuation/view_warp.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "render/light_view/view_fit.h"
#include "tests/support/random_scene.h"

namespace penumbra {
namespace {

using testing::Dice;

double NearnessAt(const LightView& view, DVec3 p) {
  const double depth = view.Project(p).z;
  return view.from_infinity ? -depth : 1 / depth;
}

// A plane as a view shows it, by three of its points.
struct ShownPlane {
  DVec2 at;
  double nearness;
  DVec2 gradient;
};

ShownPlane Show(const LightView& view, DVec3 p, DVec3 u, DVec3 v) {
  const DVec2 at(view.Project(p)), along_u = DVec2(view.Project(p + u)) - at,
                                   along_v = DVec2(view.Project(p + v)) - at;
  const double n = NearnessAt(view, p), du = NearnessAt(view, p + u) - n,
               dv = NearnessAt(view, p + v) - n;
  const double area = along_u.x * along_v.y - along_u.y * along_v.x;
  return {at, n, DVec2(du * along_v.y - dv * along_u.y, dv * along_u.x - du * along_v.x) / area};
}

// Of random lights the views that samples have of a box, with planes through it.
int CheckLight(uint64_t seed) {
  Dice dice(seed);
  const AreaLight light = testing::RandomLight(dice, static_cast<int>(seed % 6));
  Aabb box;
  box.Add(dice.InCube(3));
  box.Add(dice.InCube(3));
  int ahead = 0;
  for (const LightFace& face : FacesOf(light, box)) {
    const double pitch = std::max(face.window.size().x, face.window.size().y) / 100;
    const auto center = CenterView(face, std::array{box}, pitch);
    if (!center) continue;
    for (const LightSample& sample : SampleLight(light, 9, seed, box.center())) {
      const auto view = ViewFrom(face, sample, std::array{box}, pitch);
      if (!view) continue;
      const DVec3 p = center->PointAt(DVec2(30.3, 41.7), glm::mix(view->near, view->far, 0.6));
      if (!view->from_infinity && !(view->Project(p).z > 0.02 * view->far)) continue;
      const DVec3 u = 1e-3 * DVec3(dice.Direction()), v = 1e-3 * DVec3(dice.Direction());
      const ShownPlane here = Show(*center, p, u, v), there = Show(*view, p, u, v);
      const double scale = std::abs(here.nearness) + (view->from_infinity ? 1 : 0);
      if (glm::length(here.gradient) > scale || glm::length(there.gradient) > scale) continue;
      const ViewWarp warp(*center, *view);
      const ImagePlane start{.at = Vec2(here.at) - warp.center_origin,
                             .nearness = static_cast<float>(here.nearness),
                             .gradient = Vec2(here.gradient)};
      const ImagePlane moved = warp.ToView(start), back = warp.ToCenter(moved);
      const double reach = 1 + glm::length(DVec2(warp.move)) * std::abs(here.nearness);
      EXPECT_NEAR(moved.at.x + warp.view_origin.x, there.at.x, 1e-4 * reach) << "seed " << seed;
      EXPECT_NEAR(moved.at.y + warp.view_origin.y, there.at.y, 1e-4 * reach) << "seed " << seed;
      EXPECT_NEAR(moved.nearness, there.nearness, 1e-5 * scale) << "seed " << seed;
      EXPECT_NEAR(moved.gradient.x, there.gradient.x, 1e-5 * scale) << "seed " << seed;
      EXPECT_NEAR(moved.gradient.y, there.gradient.y, 1e-5 * scale) << "seed " << seed;
      EXPECT_NEAR(back.at.x, start.at.x, 1e-3 * reach) << "seed " << seed;
      EXPECT_NEAR(back.nearness, start.nearness, 1e-5 * scale) << "seed " << seed;
      EXPECT_NEAR(back.gradient.y, start.gradient.y, 1e-5 * scale) << "seed " << seed;
      ahead += warp.ahead != 0;
    }
  }
  return ahead;
}

TEST(ViewWarpTest, PlanesMoveAsTheirPointsDo) {
  int ahead = 0;
  for (uint64_t seed = 0; seed < 300; ++seed) ahead += CheckLight(seed);
  EXPECT_GT(ahead, 500) << "of the projective case";
}

}  // namespace
}  // namespace penumbra
