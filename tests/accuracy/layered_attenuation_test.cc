// Attenuation LDIs of 512 pixels against rays from a camera's visible points to the same samples.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <string>

#include "client/import/import_scene.h"
#include "gtest/gtest.h"
#include "tests/accuracy/ledger.h"
#include "tests/support/ldi_study.h"
#include "tests/support/pile_of_things.h"
#include "tests/support/rippled_torus.h"
#include "tests/support/scenes_folder.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

struct Worst {
  double mean = 0, p99 = 0;
};

// Compares at 64 and 256 samples, drawn by each of the ways there are.
void Compare(const std::string& name, std::vector<Instance> instances, Worst& worst) {
  LdiStudy study(OnAFloor(std::move(instances)), 2);
  for (const auto& [by_rays, samples] : {std::pair(false, 64u), std::pair(true, 64u),
                                         std::pair(false, 256u), std::pair(true, 256u)}) {
    study.DrawBy(by_rays);
    const LdiOptions options{.samples = samples};
    const LdiError error = study.Compare(study.Build(options), options);
    const auto partly = std::ranges::count_if(
        error.traced, [](float traced) { return traced > 0.02f && traced < 0.98f; });
    std::cout << name << ", " << samples << " samples" << (by_rays ? ", by rays: " : ": ")
              << error.points << " points, " << partly << " in penumbrae, mean error " << error.mean
              << ", bias " << error.bias << ", 99th percentile " << error.p99 << '\n';
    EXPECT_GT(error.points, 50'000u) << name;
    EXPECT_GT(partly, 1000) << name;
    worst.mean = std::max(worst.mean, error.mean);
    worst.p99 = std::max(worst.p99, error.p99);
  }
}

void ExpectKept(const std::string& scenes, const Worst& worst) {
  ExpectInLedger("layered_attenuation." + scenes + ".mean_abs_error", worst.mean);
  ExpectInLedger("layered_attenuation." + scenes + ".p99_abs_error", worst.p99);
}

TEST(LayeredAttenuationAccuracyTest, ScenesOfOurOwnAgreeWithRays) {
  Worst worst;
  Compare("torus", {{.id = "torus", .mesh = MeshOf(RippledTorus(160, 64))}}, worst);
  Compare("pile", PileOfThings(), worst);
  ExpectKept("own", worst);
}

TEST(LayeredAttenuationAccuracyTest, ScenesOfOtherAuthorsAgreeWithRays) {
  const auto folder = ScenesFolder(PENUMBRA_DEFAULT_SCENES);
  if (!std::filesystem::exists(folder)) {
    GTEST_SKIP() << folder << " is not there; PENUMBRA_SCENES names a folder of scenes";
  }
  Worst worst;
  for (const char* name : {"stanford-dragon-res2/dragon_vrip_res2.ply", "bridge-garden/scene.glb",
                           "flower/flower_blue.glb", "plants-unclear-licence/plants.gltf"}) {
    const auto imported = ImportScene(folder / name);
    ASSERT_TRUE(imported.ok()) << name << ": " << imported.status();
    Compare(name, imported->instances, worst);
  }
  ExpectKept("scenes", worst);
}

}  // namespace
}  // namespace penumbra::testing
