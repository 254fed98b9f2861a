// What is updated after an edit is what would have been computed from nothing.
#include <gtest/gtest.h>

#include "render/technique/soft_texture/bit_counters.h"
#include "tests/support/random_scene.h"
#include "tests/support/rippled_torus.h"
#include "tests/support/scarce_memory.h"
#include "tests/unit/technique/soft_texture_scenes.h"

namespace penumbra::testing {
namespace {

class IncrementalTest : public ::testing::Test {
 protected:
  void Have(const SceneDelta& delta) { scene_ = scene_->Apply(delta).value(); }

  Artifact ComputeOn(const Scene& scene, TechniqueMemory* memory, bool in_passes = false) {
    ComputeContext context{.arena = arena_, .memory = memory};
    passes_.clear();
    if (in_passes) context.progress = [this](Artifact pass) { passes_.push_back(std::move(pass)); };
    return TechniqueFor(spec_.params).Compute(scene, spec_, context).value();
  }
  // With what is kept, against from nothing.
  void ExpectTheSame(const std::string& what, bool in_passes = false) {
    const Artifact anew = ComputeOn(*scene_, nullptr);
    const Artifact kept = ComputeOn(*scene_, &memory_, in_passes);
    for (const Artifact& pass : passes_) {
      const VisibilityMap& map = TextureOf(pass).visibility;
      for (const uint16_t count : map.counts) ASSERT_LE(count, map.sample_count) << what;
    }
    ASSERT_EQ(TextureOf(kept).visibility.counts, TextureOf(anew).visibility.counts) << what;
  }
  // As when the next edit comes while the artifact is being refined.
  void ComputeUntilFirstPass() {
    std::stop_source stop;
    const ComputeContext context{.arena = arena_,
                                 .stop = stop.get_token(),
                                 .progress = [&](const Artifact&) { stop.request_stop(); },
                                 .memory = &memory_};
    const auto result = TechniqueFor(spec_.params).Compute(*scene_, spec_, context);
    EXPECT_TRUE(result.ok() || absl::IsCancelled(result.status()));
  }
  Instance SomeBox(int i) { return *scene_->FindInstance("box" + std::to_string(i)); }
  SceneDelta Moved(int i, Vec3 by) {
    Instance box = SomeBox(i);
    box.world_from_mesh[3] += by;
    return {.upsert_instances = {box}};
  }

  tbb::task_arena arena_{2};
  MemoryBudget budget_{size_t{64} << 20};
  TechniqueMemory memory_{budget_, nullptr};
  ArtifactSpec spec_{
      .params = SoftTextureParams{.samples = 30}, .light_id = "light", .receiver_id = "floor"};
  std::vector<Artifact> passes_;
  std::shared_ptr<const Scene> scene_ = [] {
    SceneDelta delta = RandomBoxes(20, 7);
    delta.upsert_lights = {Ceiling()};
    delta.upsert_receivers = {Floor(75, 50)};
    return SceneOf(delta);
  }();
};

TEST_F(IncrementalTest, AnyChainOfEditsGivesWhatComputingAnewGives) {
  Dice dice(11);
  for (int edit = 0; edit < 150; ++edit) {
    const int i = dice.Below(3) == 0 ? 4 : static_cast<int>(dice.Below(20));
    const std::string box = "box" + std::to_string(i);
    switch (dice.Below(9)) {
      case 0:
        if (scene_->FindInstance(box)) Have({.remove_instances = {box}});
        break;
      case 1: {
        Instance added = *scene_->instances().begin()->second;
        added.id = box;
        added.world_from_mesh[3] = dice.InCube(2) + Vec3(0, 2, 0);
        Have({.upsert_instances = {added}});
        break;
      }
      case 2: {
        if (!scene_->FindInstance(box)) break;
        Instance ghost = SomeBox(i);
        ghost.casts = !ghost.casts;
        Have({.upsert_instances = {ghost}});
        break;
      }
      case 3:
        if (dice.Below(4) == 0) Have({.upsert_lights = {Ceiling(dice.Between(3, 5))}});
        break;
      default:
        if (scene_->FindInstance(box)) Have(Moved(i, 0.2f * dice.InCube(1)));
    }
    if (dice.Below(3) == 0) ComputeUntilFirstPass();
    ExpectTheSame("edit " + std::to_string(edit), edit % 3 == 0);
  }
}

TEST_F(IncrementalTest, ADragIsDrawnOverWhatStays) {
  ExpectTheSame("at first");
  for (int step = 0; step < 5; ++step) {
    Have(Moved(3, Vec3(0.1f, 0, 0)));
    ExpectTheSame("step " + std::to_string(step), /*in_passes=*/true);
    // The first step has to draw what stays; the others need no coarse pass.
    EXPECT_EQ(passes_.empty(), step > 0) << step;
  }
}

// More rows than are drawn at a time, and fewer in the end.
TEST_F(IncrementalTest, ALargeTextureIsDrawnInBands) {
  Have({.upsert_receivers = {Floor(700, 500)}});
  ASSERT_LT(BandRows(700, 500), 500u);
  ExpectTheSame("at first");
  for (int step = 0; step < 4; ++step) {
    Have(Moved(3 + step % 2, Vec3(0.1f, 0, 0)));
    ExpectTheSame("step " + std::to_string(step), /*in_passes=*/true);
  }
}

// The box is drawn into a kept bitmap before there is no room for the flags of the torus's outline.
TEST_F(IncrementalTest, AnAllocationThatFailsLeavesNothingWrongBehind) {
  constexpr size_t kLessThanFlags = 75 * 50 * sizeof(int32_t);
  Instance torus{.id = "torus",
                 .mesh = MeshOf(RippledTorus(8, 8)),
                 .world_from_mesh = Placed(Vec3(-1, 1.2f, 0), 0.5f)};
  tbb::task_arena one(1);
  const ComputeContext context{.arena = one, .memory = &memory_};
  const auto compute = [&] { return TechniqueFor(spec_.params).Compute(*scene_, spec_, context); };
  const auto move_both = [&] {
    Have(Moved(3, Vec3(0, 0, 0.15f)));
    torus.world_from_mesh[3] += Vec3(0.1f, 0, 0);
    Have({.upsert_instances = {torus}});
  };
  for (int step = 0; step < 3; ++step) {
    move_both();
    ASSERT_TRUE(compute().ok());
  }
  move_both();
  {
    const ScarceMemory scarce(kLessThanFlags);
    EXPECT_THROW((void)compute(), std::bad_alloc);
  }
  move_both();
  const auto after = compute();
  EXPECT_EQ(TextureOf(*after).visibility.counts,
            TextureOf(ComputeOn(*scene_, nullptr)).visibility.counts);
}

TEST_F(IncrementalTest, ACancelledComputationLeavesNothingWrongBehind) {
  ExpectTheSame("at first");
  Have(Moved(3, Vec3(0.1f, 0, 0)));
  std::stop_source stop;
  stop.request_stop();
  const ComputeContext context{.arena = arena_, .stop = stop.get_token(), .memory = &memory_};
  EXPECT_TRUE(
      absl::IsCancelled(TechniqueFor(spec_.params).Compute(*scene_, spec_, context).status()));
  ExpectTheSame("after");
  Have(Moved(3, Vec3(0.1f, 0, 0)));
  ExpectTheSame("and on");
}

TEST_F(IncrementalTest, EditsThatComeBeforeTheEndStillGetThroughTheBase) {
  ExpectTheSame("at first");
  for (int step = 0; step < 6; ++step) {
    Have(Moved(3, Vec3(0.05f, 0, 0)));
    ComputeUntilFirstPass();
  }
  ExpectTheSame("in the end");
}

// What moves is nearly half of all: that takes long enough to show something first.
TEST_F(IncrementalTest, ALargeEditShowsACoarsePassFirst) {
  const auto ball = MeshOf(BallGeometry(80, 80));
  Instance still{.id = "still", .mesh = ball, .world_from_mesh = Placed(Vec3(1, 1, 1), 0.3f)};
  Instance moved{.id = "moved", .mesh = ball, .world_from_mesh = Placed(Vec3(-1, 1, 0), 0.3f)};
  Have({.upsert_instances = {still, moved}});
  ExpectTheSame("at first");
  for (int step = 0; step < 3; ++step) {
    moved.world_from_mesh[3] += Vec3(0.1f, 0, 0);
    Have({.upsert_instances = {moved}});
    ExpectTheSame("step " + std::to_string(step), /*in_passes=*/true);
    ASSERT_FALSE(passes_.empty());
    EXPECT_EQ(TextureOf(passes_[0]).visibility.sample_count, 8u);
  }
}

TEST_F(IncrementalTest, ScenesThatAreGoneAreNotHeldOnTo) {
  Instance visitor = SomeBox(3);
  visitor.id = "visitor";
  visitor.mesh = MeshOf(BallGeometry(8, 6));
  const std::weak_ptr<const Mesh> mesh = visitor.mesh;
  Have({.upsert_instances = {visitor}});
  ExpectTheSame("with it");
  Have(Moved(4, Vec3(0.1f, 0, 0)));
  ExpectTheSame("and a base that it is in");
  visitor = {};
  Have({.remove_instances = {"visitor"}});
  EXPECT_TRUE(mesh.expired());
}

TEST_F(IncrementalTest, WithoutBudgetEverythingIsDrawn) {
  MemoryBudget none(1000);
  TechniqueMemory memory{none, nullptr};
  for (int step = 0; step < 3; ++step) {
    Have(Moved(3, Vec3(0.1f, 0, 0)));
    EXPECT_EQ(TextureOf(ComputeOn(*scene_, &memory)).visibility.counts,
              TextureOf(ComputeOn(*scene_, nullptr)).visibility.counts);
  }
}

TEST_F(IncrementalTest, WhatIsKeptIsGivenBack) {
  {
    TechniqueMemory memory{budget_, nullptr};
    for (int step = 0; step < 3; ++step) {
      Have(Moved(step, Vec3(0.1f, 0, 0)));
      ComputeOn(*scene_, &memory);
    }
    EXPECT_FALSE(budget_.Take(size_t{64} << 20));
  }
  EXPECT_TRUE(budget_.Take(size_t{64} << 20));
}

TEST_F(IncrementalTest, OtherParametersBeginAnew) {
  for (const uint32_t samples : {30u, 12u, 30u}) {
    std::get<SoftTextureParams>(spec_.params).samples = samples;
    Have(Moved(5, Vec3(0.05f, 0, 0)));
    ExpectTheSame(std::to_string(samples));
  }
}

}  // namespace
}  // namespace penumbra::testing
