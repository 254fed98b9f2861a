// Techniques that look from the light's middle alone, against rays from what a camera sees: shadow
// volumes against hard shadows, shadow widths against the fraction of the light that is seen.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/gtc/matrix_transform.hpp>
#include <iostream>
#include <string>

#include "render/artifact/artifact.h"
#include "render/artifact/light_extent.h"
#include "render/scene/light_sample.h"
#include "render/technique/technique.h"
#include "tests/accuracy/ledger.h"
#include "tests/support/eye_rays.h"
#include "tests/support/pile_of_things.h"
#include "tests/support/rippled_torus.h"
#include "tests/support/scenes_on_floors.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

// Points that a camera sees, and what rays say of each: whether the light's middle is hidden, and
// what part of its samples is seen.
struct Traced {
  EyeView view;
  std::vector<uint8_t> dark;
  std::vector<float> seen;
};

Traced Trace(const Scene& scene, const AreaLight& light, tbb::task_arena& arena) {
  const Aabb bounds = scene.Bounds();
  const DVec3 middle(bounds.center());
  const double reach = glm::length(DVec3(bounds.extent()));
  const EyeImage eye{.clip_from_world = glm::perspective(0.8, 1.0, 0.01 * reach, 10 * reach) *
                                        glm::lookAt(middle + reach * DVec3(0.5, 0.45, 0.7), middle,
                                                    DVec3(0, 1, 0)),
                     .width = 320,
                     .height = 320,
                     .near = 0.01 * reach};
  const EyeRays rays(scene);
  const auto offset = static_cast<float>(1e-5 * reach);
  Traced traced{.view = rays.See(eye, arena), .dark = {}, .seen = {}};
  traced.dark = rays.Shadow(traced.view, DVec4(LightExtent(light).center(), 1), offset, arena);
  traced.seen.resize(traced.dark.size());
  const auto samples = SampleLight(light, 64, 1, scene.Bounds().center());
  for (const LightSample& sample : samples) {
    const auto dark = rays.Shadow(traced.view, DVec4(DVec3(sample.point), 1), offset, arena);
    for (size_t i = 0; i < dark.size(); ++i) {
      traced.seen[i] += (1 - dark[i]) / static_cast<float>(samples.size());
    }
  }
  return traced;
}

// These rays know no masks.
std::shared_ptr<const Scene> WithoutMasks(const Scene& scene) {
  SceneDelta delta;
  for (const auto& [id, instance] : scene.instances()) {
    delta.upsert_instances.push_back(*instance);
    delta.upsert_instances.back().alpha_mask = nullptr;
  }
  return scene.Apply(delta).value();
}

struct Errors {
  size_t points = 0;
  double wrong = 0, mean = 0;  // of points: hidden and not, or the other way; of what is seen
};

class OneSampleAccuracyTest : public ::testing::Test {
 protected:
  void Compare(const std::string& name, const Scene& scene) {
    const auto& [id, light] = *scene.lights().begin();
    const Traced traced = Trace(scene, *light, arena_);
    const auto compute = [&](const TechniqueParams& params) {
      return TechniqueFor(params).Compute(scene, {params, id}, {.arena = arena_}).value();
    };
    const Artifact volumes = compute(ShadowVolumeParams{}), widths = compute(ShadowWidthParams{});
    const VolumeLookup lookup(std::get<ShadowVolumeMesh>(volumes.payload));
    Errors own;
    for (size_t i = 0; i < traced.dark.size(); ++i) {
      if (traced.view.inverse_depths[i] == 0) continue;
      const Vec3 point = traced.view.points[i], normal = traced.view.normals[i];
      ++own.points;
      // What faces away is dark however it is looked up.
      const bool faces_it =
          glm::dot(LightExtent(*light).center() - DVec3(point), DVec3(normal)) > 0;
      own.wrong += faces_it && (lookup.Depth(DVec3(point)) > 0) != (traced.dark[i] != 0);
      if (i % 5 != 0) continue;  // as is enough for a mean
      own.mean += 5 * std::abs(Visibility(widths, point, normal) - traced.seen[i]);
    }
    const auto count = static_cast<double>(own.points);
    std::cout << name << ": " << own.points << " points, of shadow volumes " << own.wrong / count
              << " wrong, of shadow widths a mean error of " << own.mean / count << '\n';
    EXPECT_GT(own.points, 30'000u) << name;
    worst_.wrong = std::max(worst_.wrong, own.wrong / count);
    worst_.mean = std::max(worst_.mean, own.mean / count);
  }
  void ExpectKept(const std::string& scenes) const {
    ExpectInLedger("shadow_volume." + scenes + ".wrong_fraction", worst_.wrong);
    ExpectInLedger("shadow_width." + scenes + ".mean_abs_error", worst_.mean);
  }

 private:
  tbb::task_arena arena_{2};
  Errors worst_;
};

TEST_F(OneSampleAccuracyTest, ScenesOfOurOwn) {
  Compare("torus", *OnFloor({{.id = "torus", .mesh = MeshOf(RippledTorus(160, 64))}}));
  Compare("pile", *OnFloor(PileOfThings()));
  ExpectKept("own");
}

TEST_F(OneSampleAccuracyTest, ScenesOfOtherAuthors) {
  const auto folder = ScenesFolder(PENUMBRA_DEFAULT_SCENES);
  if (!std::filesystem::exists(folder)) {
    GTEST_SKIP() << folder << " is not there; PENUMBRA_SCENES names a folder of scenes";
  }
  for (const auto& [name, path] : kScenesOnFloors) {
    const auto scene = LoadOnFloor(folder / path);
    ASSERT_TRUE(scene.ok()) << name << ": " << scene.status();
    Compare(name, *WithoutMasks(**scene));
  }
  ExpectKept("scenes");
}

}  // namespace
}  // namespace penumbra::testing
