// The client library's one call for every light on every receiver.
#include <map>

#include "render/scene/field_error.h"
#include "tests/integration/session/remote_engine_fixture.h"

namespace penumbra::testing {
namespace {

// The newest final artifact of each spec.
class Collection {
 public:
  RemoteEngine::EachCallback callback() {
    return [this](const ArtifactSpec& spec, const ArtifactUpdate& update, const UpdateTraffic&) {
      std::lock_guard lock(mutex_);
      if (!update.artifact || !update.artifact->header.is_final) return;
      newest_[{spec.light_id, spec.receiver_id}] = update;
      came_.notify_all();
    };
  }
  bool WaitForAll(size_t count, Revision revision) {
    std::unique_lock lock(mutex_);
    return came_.wait_for(lock, kPatience, [&] {
      size_t there = 0;
      for (const auto& [key, update] : newest_) there += update.revision >= revision ? 1 : 0;
      return there == count;
    });
  }

 private:
  std::mutex mutex_;
  std::condition_variable came_;
  std::map<std::pair<std::string, std::string>, ArtifactUpdate> newest_;
};

TEST_F(RemoteEngineTest, EveryPolygonIsSubscribedToByOneCall) {
  auto engine = Connect();
  ASSERT_TRUE(engine->CreateScene("room").ok());
  SceneDelta delta = Studio();
  delta.receive_on_planar_surfaces = PlanarSurfaceRequest{};
  ASSERT_TRUE(engine->Commit("room", delta).ok());
  const auto mirrored = engine->Snapshot("room");
  ASSERT_TRUE(mirrored.ok()) << mirrored.status();
  EXPECT_EQ((*mirrored)->receivers().size(), 7u) << "the mirror makes the same receivers";

  Collection collection;
  auto all = engine->SubscribeEach("room", {.params = SoftTextureParams{.samples = 8}},
                                   collection.callback());
  ASSERT_TRUE(all.ok()) << all.status();
  ASSERT_EQ(all->size(), 7u);
  EXPECT_EQ(all->front().spec.receiver_id, "floor");
  EXPECT_TRUE(collection.WaitForAll(7, 1));
  ASSERT_TRUE(engine->Commit("room", Studio(Vec3(0.5f, 0.6f, 0))).ok());
  EXPECT_TRUE(collection.WaitForAll(7, 2));
  all->clear();

  const auto unknown =
      engine->SubscribeEach("room", {.light_ids = {"ghost"}}, collection.callback());
  EXPECT_EQ(unknown.status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(ErrorFieldPath(unknown.status()), "light_ids[0]");
}

}  // namespace
}  // namespace penumbra::testing
