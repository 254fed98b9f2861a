#include "render/scene/caster_tree.h"

#include <set>

#include "absl/strings/str_cat.h"
#include "gtest/gtest.h"
#include "render/scene/scene.h"
#include "tests/support/random_scene.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

bool Meet(const Aabb& a, const Aabb& b) {
  return glm::all(glm::lessThanEqual(a.min, b.max)) && glm::all(glm::lessThanEqual(b.min, a.max));
}

SceneDelta RandomBoxes(Dice& dice, int count) {
  SceneDelta delta;
  const auto box = MeshOf(UnitBoxGeometry());
  for (int i = 0; i < count; ++i) {
    delta.upsert_instances.push_back(
        {.id = absl::StrCat("i", i),
         .mesh = i % 50 == 0 ? MeshOf({}) : box,
         .world_from_mesh = dice.AnyAffine(dice.Between(0.01f, 0.5f), dice.InCube(5)),
         .casts = dice.Below(10) != 0});
  }
  return delta;
}

TEST(CasterTreeTest, VisitsWhatLookingAtEachFinds) {
  Dice dice(1);
  for (const int count : {0, 1, 2, 3, 700}) {
    const auto scene = Scene::Empty("s")->Apply(RandomBoxes(dice, count)).value();
    for (int trial = 0; trial < 50; ++trial) {
      Aabb window;
      window.Add(dice.InCube(5));
      window.Add(window.min + glm::abs(dice.InCube(2)));
      std::multiset<std::string> expected, found;
      for (const auto& [id, instance] : scene->instances()) {
        if (instance->casts && Meet(CasterBounds(*instance), window)) expected.insert(id);
      }
      scene->casters().Visit(
          [&](const Aabb& box) { return Meet(box, window); },
          [&](const std::shared_ptr<const Instance>& caster) { found.insert(caster->id); });
      ASSERT_EQ(found, expected) << count << " boxes, trial " << trial;
    }
  }
}

TEST(CasterTreeTest, BoundsHoldEveryVertexWhateverTheRounding) {
  Dice dice(2);
  for (int trial = 0; trial < 2000; ++trial) {
    // Far from its own origin and moved back, so that most digits cancel.
    MeshGeometry geometry = UnitBoxGeometry();
    const Vec3 away = dice.InCube(std::pow(10.0f, dice.Between(-2, 6)));
    for (Vec3& p : geometry.positions) p += away;
    Instance instance{.id = "far", .mesh = MeshOf(std::move(geometry))};
    instance.world_from_mesh = dice.AnyAffine(1, Vec3(0));
    instance.world_from_mesh[3] = -TransformPoint(instance.world_from_mesh, away);
    const Aabb bounds = CasterBounds(instance);
    for (const Vec3 p : instance.mesh->positions()) {
      const Vec3 at = TransformPoint(instance.world_from_mesh, p);
      ASSERT_TRUE(Meet(bounds, {at, at})) << trial;
    }
  }
}

TEST(CasterTreeTest, IsSharedUntilAnInstanceChanges) {
  Dice dice(3);
  const auto scene = Scene::Empty("s")->Apply(RandomBoxes(dice, 20)).value();
  const CasterTree* tree = &scene->casters();
  const auto lit = scene->Apply({.upsert_lights = {RandomLight(dice, 0)}}).value();
  EXPECT_EQ(&lit->casters(), tree);
  EXPECT_EQ(&scene->WithRevision(9)->casters(), tree);
  Instance changed = *scene->FindInstance("i7");
  changed.casts = true;
  const auto edited = lit->Apply({.upsert_instances = {changed}}).value();
  EXPECT_NE(&edited->casters(), tree);
  EXPECT_EQ(&scene->casters(), tree);
}

}  // namespace
}  // namespace penumbra::testing
