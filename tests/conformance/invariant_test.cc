// What may change without changing the shadows, and how they may change.
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "gtest/gtest.h"
#include "render/scene/light_sample.h"
#include "tests/conformance/conformance.h"
#include "tests/support/random_scene.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

class InvariantTest : public ConformanceTest {
 protected:
  void ExpectNoBrighter(const std::vector<float>& before, const std::vector<float>& after,
                        const std::string& what);
};

Vec3 Turned(const Affine& m, Vec3 v) { return m * Vec4(v, 0.0f); }

// A rotation about a slanting axis, a uniform scale and a shift.
Affine RigidAndScale() {
  const Vec3 x = glm::normalize(Vec3(0.8f, 0.1f, -0.5f));
  const Vec3 z = glm::normalize(glm::cross(x, Vec3(0.2f, 1, 0.1f)));
  const float scale = 1.75f;
  return Affine(scale * x, scale * glm::cross(z, x), scale * z, Vec3(3, -1, 2));
}

Stage Moved(Stage stage, const Affine& motion) {
  auto& light = std::get<RectangleLight>(stage.light);
  light.corner = TransformPoint(motion, light.corner);
  light.edge_u = Turned(motion, light.edge_u);
  light.edge_v = Turned(motion, light.edge_v);
  auto& patch = std::get<Parallelogram>(stage.receiver.shape);
  patch.origin = TransformPoint(motion, patch.origin);
  patch.edge_u = Turned(motion, patch.edge_u);
  patch.edge_v = Turned(motion, patch.edge_v);
  for (Instance& instance : stage.occluders) {
    Affine& m = instance.world_from_mesh;
    m = Affine(Turned(motion, m[0]), Turned(motion, m[1]), Turned(motion, m[2]),
               TransformPoint(motion, m[3]));
  }
  return stage;
}

Stage Boxes(LightShape light) {
  return {.light = std::move(light),
          .receiver = OddFloor(),
          .occluders = {BoxOver(Vec3(0.3f, 0.8f, 0.1f), Vec3(0.2f, 0.3f, 0.4f)),
                        BoxOver(Vec3(-0.5f, 1.2f, -0.2f), Vec3(0.1f, 0.1f, 0.5f)),
                        SheetOver(Vec3(-0.2f, 0.4f, 0.7f), Vec3(0.4f, 1, 0.2f))}};
}

TEST_P(InvariantTest, RigidMotionAndUniformScaleChangeNothing) {
  const Stage stage = Boxes(LightsOverhead()[0].second);
  const auto grid = Visibilities(stage);
  EXPECT_GT(Mean(grid), 0.3f);
  EXPECT_LT(Mean(grid), 0.95f);
  // Rounding may move a sample or two across an edge.
  const auto moved = Visibilities(Moved(stage, RigidAndScale()));
  ExpectAlike(grid, moved, 2.01f / 64, 0.01f);
}

TEST_P(InvariantTest, A12ALightShrunkToAPointGivesTheHardShadow) {
  const Vec3 at(0.1f, 2, 0.05f);
  const auto hard = Visibilities(Boxes(PointLight{.position = at}));
  const LightShape tiny[] = {
      RectangleLight{.corner = at, .edge_u = Vec3(1e-4f, 0, 0), .edge_v = Vec3(0, 0, 1e-4f)},
      DiskLight{.center = at, .radius = 1e-4f}, SphereLight{.center = at, .radius = 1e-4f}};
  for (const LightShape& light : tiny) {
    ExpectAlike(Visibilities(Boxes(light)), hard, 1, 0.005f);
  }
  const Vec3 up(0.2f, 1, 0.1f);
  ExpectAlike(Visibilities(Boxes(DistantLight{.to_light = up, .angular_diameter = 1e-4f})),
              Visibilities(Boxes(DistantLight{.to_light = up})), 1, 0.005f);
}

TEST_P(InvariantTest, TheSameSeedGivesTheSameBitsAndAnotherDoesNot) {
  for (const auto& [name, light] : LightsOverhead()) {
    const Stage stage = Boxes(light);
    const auto grid = Visibilities(stage, 48, 5);
    EXPECT_EQ(grid, Visibilities(stage, 48, 5)) << name;
    const bool has_size = name != "point" && name != "spot";
    EXPECT_EQ(grid != Visibilities(stage, 48, 6), has_size && has_seed()) << name;
  }
}

// Exactly, texel by texel, where counts are exact. Elsewhere, on the whole: a light's image has its
// pixels elsewhere once the scene is larger, and what is predicted goes by other points.
void InvariantTest::ExpectNoBrighter(const std::vector<float>& before,
                                     const std::vector<float>& after, const std::string& what) {
  const bool is_exact = target() == SpecTarget::kReceiver;
  const float slack = is_exact ? 0.0f : 0.25f;
  const float part = target() == SpecTarget::kScene ? 0.03f : 0.002f;
  size_t brighter = 0;
  for (size_t t = 0; t < after.size(); ++t) brighter += after[t] > before[t] + slack;
  EXPECT_LE(brighter, is_exact ? 0 : part * static_cast<float>(after.size())) << what;
  EXPECT_LE(Mean(after), Mean(before) + (is_exact ? 0.0f : 0.01f)) << what;
}

TEST_P(InvariantTest, AnotherOccluderNeverBrightens) {
  for (uint64_t seed = 0; seed < 2 * kLightKinds; ++seed) {
    const auto full = RandomScene(seed);
    // Of plausible shadows, a blocker nearer to a light that has a size softens those of another in
    // its place; hard ones have nothing to soften.
    const auto has_size = [](const auto& entry) {
      return EffectiveSampleCount(*entry.second, 2) > 1;
    };
    if (is_plausible() && std::ranges::any_of(full->lights(), has_size)) continue;
    SceneDelta delta;
    for (const auto& [id, light] : full->lights()) delta.upsert_lights.push_back(*light);
    for (const auto& [id, receiver] : full->receivers())
      delta.upsert_receivers.push_back(*receiver);
    const std::string scene = NewScene(delta);
    std::vector<float> before = Visibilities(scene, Spec(scene));
    for (const auto& [id, instance] : full->instances()) {
      ASSERT_TRUE(engine_->Commit(scene, {.upsert_instances = {*instance}}).ok());
      const std::vector<float> after = Visibilities(scene, Spec(scene));
      ExpectNoBrighter(before, after, "seed " + std::to_string(seed) + ", with " + id);
      before = after;
    }
  }
}

PENUMBRA_INSTANTIATE_CONFORMANCE(InvariantTest);

}  // namespace
}  // namespace penumbra::testing
