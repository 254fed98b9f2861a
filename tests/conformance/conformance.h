// What every technique must do on every engine. Artifacts are looked into through Visibility()
// alone, so that the tests hold for all kinds.
#pragma once

#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "gtest/gtest.h"
#include "render/engine/engine.h"
#include "tests/support/engine_under_test.h"

namespace penumbra::testing {

// A technique's parameters with this many samples and this seed, if it has such parameters.
TechniqueParams With(TechniqueParams params, uint32_t samples, uint64_t seed = 1);

// A scene's parts as the tests vary them: a light "light" and a receiver "receiver".
struct Stage {
  LightShape light;
  Receiver receiver;
  std::vector<Instance> occluders{};

  SceneDelta delta() const;
};

// The visible fraction at each texel centre of the receiver, row after row. An artifact of given
// points must be of these.
std::vector<float> VisibilityGrid(const Scene& scene, const Artifact& artifact);

// Parameter: an index into EnginesUnderTest() and one into AllTechniques().
class ConformanceTest : public ::testing::TestWithParam<std::tuple<size_t, size_t>> {
 protected:
  ConformanceTest();

  TechniqueParams params(uint32_t samples = 64, uint64_t seed = 1) const;
  SpecTarget target() const { return InfoOf(params()).target; }
  // Parameters that some techniques have none of.
  bool has_samples() const {
    return std::visit(
        [](const auto& p) {
          return requires { p.samples; };
        },
        params());
  }
  bool has_seed() const {
    return std::visit(
        [](const auto& p) {
          return requires { p.seed; };
        },
        params());
  }
  // Shadows are not those of the light: what follows from that they are does not hold.
  bool is_plausible() const { return InfoOf(params()).is_plausible; }
  // Of the light and the receiver, or what stands for the receiver: its texels' centres as points.
  ArtifactSpec Spec(const std::string& scene_id, uint32_t samples = 64, uint64_t seed = 1) const;

  // Of a new scene that holds `stage` and nothing else.
  std::vector<float> Visibilities(const Stage& stage, uint32_t samples = 64, uint64_t seed = 1);
  std::vector<float> Visibilities(const std::string& scene_id, const ArtifactSpec& spec);
  std::shared_ptr<const Artifact> Compute(const std::string& scene_id, const ArtifactSpec& spec);
  std::string NewScene(const SceneDelta& delta);

  // That two grids are of the same shadows. What is sampled in a light's image is the same up to
  // where pixels lie, within the bounds that tests/accuracy holds it to.
  void ExpectAlike(const std::vector<float>& a, const std::vector<float>& b, float tolerance,
                   float differing_part, const std::string& what = "");

  const std::shared_ptr<Engine> engine_;

 private:
  int scenes_made_ = 0;
};

// Every engine with every technique, named "Local_soft_texture" and so on.
#define PENUMBRA_INSTANTIATE_CONFORMANCE(suite)                                  \
  INSTANTIATE_TEST_SUITE_P(                                                      \
      All, suite,                                                                \
      ::testing::Combine(::testing::Range(size_t{0}, EnginesUnderTest().size()), \
                         ::testing::Range(size_t{0}, AllTechniques().size())),   \
      [](const auto& test) { return ConformanceName(test.param); })

std::string ConformanceName(const std::tuple<size_t, size_t>& param);

float Mean(const std::vector<float>& values);
float MeanDifference(const std::vector<float>& a, const std::vector<float>& b);
// The part of the texels at which `a` and `b` are further apart than `tolerance`.
float DifferingPart(const std::vector<float>& a, const std::vector<float>& b, float tolerance);

// The lights that tests of invariants go through, all about 2 m above the floor.
std::vector<std::pair<std::string, LightShape>> LightsOverhead();

// A floor of 4 m with odd numbers of texels, and an opaque box over it.
Receiver OddFloor();
Instance BoxOver(Vec3 center, Vec3 half);
Instance SheetOver(Vec3 center, Vec3 half);

}  // namespace penumbra::testing
