// All depth sources on scenes of other authors, which are looked for where PENUMBRA_SCENES says:
// they agree, and where they do not, rounding decides, as double precision tells.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "render/light_view/gl_depth_source.h"
#include "render/light_view/raster_depth_source.h"
#include "render/light_view/ray_depth_source.h"
#include "render/light_view/view_fit.h"
#include "render/scene/light_sample.h"
#include "tests/support/drawn_views.h"
#include "tests/support/nearest_depth.h"
#include "tests/support/scenes_on_floors.h"

namespace penumbra::testing {
namespace {

constexpr double kPixels = 512;

// Of the lamp's four samples, about kPixels wide.
std::vector<LightView> ViewsOf(const Scene& scene) {
  const AreaLight& lamp = *scene.FindLight("lamp");
  const LightFace face = FacesOf(lamp, scene.Bounds()).at(0);
  const auto boxes = CasterBoxes(scene);
  const double pitch = CenterView(face, boxes, 1e-4)->window.size().x / kPixels;
  std::vector<LightView> views;
  for (const LightSample& sample : SampleLight(lamp, 4, 1, scene.Bounds().center())) {
    views.push_back(ViewFrom(face, sample, boxes, pitch).value());
  }
  return views;
}

struct Agreement {
  size_t pixels = 0, seen = 0, differing = 0;
  size_t a_wrong = 0, b_wrong = 0;  // where double precision is sure
};

Agreement Compare(const DepthMap& a, const DepthMap& b,
                  const std::vector<OccluderTriangle>& triangles) {
  // Each look at all triangles takes a few milliseconds.
  constexpr size_t kMostJudged = 64;
  Agreement result{.pixels = a.depths.size()};
  for (uint32_t y = 0; y < a.view.height; ++y) {
    for (uint32_t x = 0; x < a.view.width; ++x) {
      result.seen += a.At(x, y) != kNoDepth;
      if (AreSameDepth(a.At(x, y), b.At(x, y))) continue;
      if (++result.differing > kMostJudged) continue;
      const double exact = NearestDepth(a.view, x, y, triangles);
      if (std::isnan(exact)) continue;
      result.a_wrong += !AreSameDepth(exact, a.At(x, y));
      result.b_wrong += !AreSameDepth(exact, b.At(x, y));
    }
  }
  return result;
}

void ExpectAgreement(const std::string& name, const std::vector<DepthMap>& raster,
                     const std::vector<DepthMap>& other,
                     const std::vector<OccluderTriangle>& triangles) {
  ASSERT_EQ(raster.size(), other.size());
  for (size_t i = 0; i < raster.size(); ++i) {
    const Agreement one = Compare(raster[i], other[i], triangles);
    std::cout << name << ": " << one.pixels << " pixels, " << one.seen << " see something, "
              << one.differing << " differ; sure to be wrong: " << one.a_wrong << " of raster, "
              << one.b_wrong << " of it\n";
    EXPECT_GT(one.seen, one.pixels / 2) << name;
    EXPECT_LE(one.differing, one.pixels / 2'000) << name;
    EXPECT_EQ(one.a_wrong, 0u) << name;
    EXPECT_EQ(one.b_wrong, 0u) << name;
  }
}

TEST(DepthScenesTest, SourcesAgreeOnScenesOfOtherAuthors) {
  const auto folder = ScenesFolder(PENUMBRA_DEFAULT_SCENES);
  if (!std::filesystem::exists(folder)) {
    GTEST_SKIP() << folder << " is not there; PENUMBRA_SCENES names a folder of scenes";
  }
  const auto context = gl::Context::Create({.device = "software"});
  ASSERT_TRUE(context.ok()) << context.status();
  for (const auto& [name, path] : kScenesOnFloors) {
    const auto scene = LoadOnFloor(folder / path);
    ASSERT_TRUE(scene.ok()) << name << ": " << scene.status();
    const auto triangles = OccluderTriangles(**scene);
    tbb::task_arena arena;
    CasterBvhs bvhs;
    RasterDepthSource raster(**scene, arena);
    RayDepthSource rays(bvhs.Of(**scene), arena);
    GlDepthSource by_gl(**scene, **context, "a.method");
    const auto views = ViewsOf(**scene);
    const auto drawn = DrawAll(raster, views);
    ExpectAgreement(std::string(name) + " by rays", drawn, DrawAll(rays, views), triangles);
    ExpectAgreement(std::string(name) + " by gl", drawn, DrawAll(by_gl, views), triangles);
  }
}

}  // namespace
}  // namespace penumbra::testing
