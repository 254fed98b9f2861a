// Editing: nothing is remembered but the scene.
#include <condition_variable>
#include <mutex>

#include "gtest/gtest.h"
#include "render/engine/compute_once.h"
#include "tests/conformance/conformance.h"
#include "tests/support/random_scene.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

class EditTest : public ConformanceTest {
 protected:
  Revision Commit(const std::string& scene, const SceneDelta& delta) {
    const auto revision = engine_->Commit(scene, delta);
    EXPECT_TRUE(revision.ok()) << revision.status();
    return revision.ok() ? *revision : 0;
  }
  ContentHash Hash(const std::string& scene) {
    return engine_->Snapshot(scene).value()->content_hash();
  }
};

SceneDelta Whole(const Scene& scene) {
  SceneDelta delta;
  for (const auto& [id, instance] : scene.instances()) delta.upsert_instances.push_back(*instance);
  for (const auto& [id, light] : scene.lights()) delta.upsert_lights.push_back(*light);
  for (const auto& [id, receiver] : scene.receivers()) delta.upsert_receivers.push_back(*receiver);
  return delta;
}

// The same scene, made over many detours.
TEST_P(EditTest, UndoingDeletingAndAddingAgainLeavesTheSameBits) {
  for (uint64_t seed = 0; seed < kLightKinds; ++seed) {
    const auto wanted = RandomScene(seed);
    const std::string direct = NewScene(Whole(*wanted)), detour = NewScene(Whole(*wanted));
    const auto grid = Visibilities(direct, Spec(direct));
    for (const auto& [id, instance] : wanted->instances()) {
      Instance moved = *instance;
      moved.world_from_mesh[3] += Vec3(0.3f, -0.2f, 0.1f);
      Commit(detour, {.upsert_instances = {moved}});
      if (seed % 2 == 0) Compute(detour, Spec(detour));
      Commit(detour, {.upsert_instances = {*instance}});
    }
    EXPECT_EQ(Visibilities(detour, Spec(detour)), grid) << "moved and moved back, seed " << seed;
    for (const auto& [id, instance] : wanted->instances()) {
      Commit(detour, {.remove_instances = {id}});
    }
    Compute(detour, Spec(detour));
    for (auto it = wanted->instances().rbegin(); it != wanted->instances().rend(); ++it) {
      Commit(detour, {.upsert_instances = {*it->second}});
    }
    EXPECT_EQ(Visibilities(detour, Spec(detour)), grid) << "removed and added again, seed " << seed;
    Commit(detour, {.remove_lights = {"light"}, .remove_receivers = {"receiver"}});
    Commit(detour, {.upsert_lights = {*wanted->FindLight("light")},
                    .upsert_receivers = {*wanted->FindReceiver("receiver")}});
    EXPECT_EQ(Visibilities(detour, Spec(detour)), grid) << "another light and back, seed " << seed;
    EXPECT_EQ(Hash(detour), Hash(direct));
  }
}

TEST_P(EditTest, TheHeaderSaysWhatWasComputed) {
  const Stage stage{.light = LightsOverhead()[0].second,
                    .receiver = OddFloor(),
                    .occluders = {BoxOver(Vec3(0, 1, 0), Vec3(0.3f))}};
  const std::string scene = NewScene(stage.delta());
  Commit(scene, {.upsert_instances = {[] {
                   Instance box = BoxOver(Vec3(0.1f, 1, 0), Vec3(0.3f));
                   box.id = "occluder0";
                   return box;
                 }()}});
  const ArtifactHeader header = Compute(scene, Spec(scene, 40, 7))->header;
  EXPECT_EQ(header.scene_id, scene);
  EXPECT_EQ(header.revision, 2u);
  EXPECT_EQ(header.scene_hash, Hash(scene));
  EXPECT_EQ(header.technique, InfoOf(params()).name);
  EXPECT_EQ(header.light_id, "light");
  EXPECT_EQ(header.receiver_id, target() == SpecTarget::kReceiver ? "receiver" : "");
  EXPECT_TRUE(header.is_final);
  // Points have samples of their own each, in a square grid.
  const bool has_common_samples = target() != SpecTarget::kPoints;
  const uint32_t common = has_samples() ? 40u : 1u;
  EXPECT_EQ(header.samples_requested, has_common_samples ? common : 36u);
  ASSERT_EQ(header.light_samples.size(), has_common_samples ? common : 0u);
  float weights = 0;
  for (const LightSample& sample : header.light_samples) weights += sample.weight;
  EXPECT_NEAR(weights, has_common_samples ? 1 : 0, 1e-5);
  EXPECT_GE(header.error_estimate, 0);
  EXPECT_LE(header.error_estimate, 0.5f);
}

// A subscription across edits: revisions never go back, and the last one comes, finished.
TEST_P(EditTest, ASubscriptionFollowsEdits) {
  const Stage stage{.light = LightsOverhead()[0].second,
                    .receiver = OddFloor(),
                    .occluders = {BoxOver(Vec3(0, 1, 0), Vec3(0.3f))}};
  const std::string scene = NewScene(stage.delta());
  std::mutex mutex;
  std::condition_variable came;
  std::vector<ArtifactUpdate> updates;
  const auto subscription =
      engine_->Subscribe(scene, Spec(scene), [&](const ArtifactUpdate& update) {
        std::lock_guard lock(mutex);
        updates.push_back(update);
        came.notify_all();
      });
  ASSERT_TRUE(subscription.ok()) << subscription.status();
  Revision last = 0;
  Instance box = BoxOver(Vec3(0, 1, 0), Vec3(0.3f));
  box.id = "occluder0";
  for (int i = 0; i < 60; ++i) {
    box.world_from_mesh[3].x = 0.01f * static_cast<float>(i);
    last = Commit(scene, {.upsert_instances = {box}});
  }
  {
    std::unique_lock lock(mutex);
    came.wait(lock, [&] {
      return !updates.empty() && updates.back().revision == last && updates.back().status.ok() &&
             updates.back().artifact->header.is_final;
    });
    for (size_t i = 1; i < updates.size(); ++i) {
      EXPECT_LE(updates[i - 1].revision, updates[i].revision);
      EXPECT_TRUE(updates[i].status.ok()) << updates[i].status;
    }
  }
  Stage at_last = stage;
  at_last.occluders = {box};
  EXPECT_EQ(VisibilityGrid(*engine_->Snapshot(scene).value(), *updates.back().artifact),
            Visibilities(at_last));
}

PENUMBRA_INSTANTIATE_CONFORMANCE(EditTest);

}  // namespace
}  // namespace penumbra::testing
