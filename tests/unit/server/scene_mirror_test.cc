#include "server/session/scene_mirror.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "penumbra/v1/session.pb.h"
#include "proto/convert/geometry_convert.h"
#include "render/scene/scene_difference.h"
#include "tests/support/random_scene.h"
#include "tests/support/shapes.h"

namespace penumbra {
namespace {

using ::testing::ElementsAre;

Instance Box(const std::string& id, float x = 0) {
  static const auto mesh = testing::MeshOf(testing::UnitBoxGeometry());
  return {.id = id, .mesh = mesh, .world_from_mesh = testing::Placed({x, 0, 0})};
}

std::shared_ptr<const Scene> With(const std::shared_ptr<const Scene>& scene, Instance instance) {
  SceneDelta delta;
  delta.upsert_instances = {std::move(instance)};
  return scene->Apply(delta).value();
}

std::shared_ptr<const Scene> Without(const std::shared_ptr<const Scene>& scene, std::string id) {
  SceneDelta delta;
  delta.remove_instances = {std::move(id)};
  return scene->Apply(delta).value();
}

TEST(DifferenceTest, TurnsTheOneIntoTheOther) {
  const auto empty = Scene::Empty("s");
  const auto from = With(With(With(empty, Box("a")), Box("b")), Box("d"));
  const auto to = With(Without(With(from, Box("b", 5)), "a"), Box("c"));
  const SceneDelta delta = Difference(*from, *to);
  EXPECT_THAT(delta.remove_instances, ElementsAre("a"));
  ASSERT_EQ(delta.upsert_instances.size(), 2u);
  EXPECT_EQ(delta.upsert_instances[0].id, "b");
  EXPECT_EQ(delta.upsert_instances[1].id, "c");
  EXPECT_EQ((*from->Apply(delta))->content_hash(), to->content_hash());
  EXPECT_TRUE(Difference(*to, *to).empty());
  EXPECT_EQ((*to->Apply(Difference(*to, *empty)))->content_hash(), empty->content_hash());
}

constexpr size_t kMessage = 1 << 20;

v1::SceneUpdate UpdateIn(const grpc::ByteBuffer& message) {
  grpc::Slice slice;
  EXPECT_TRUE(message.DumpToSingleSlice(&slice).ok());
  v1::SessionResponse response;
  EXPECT_TRUE(response.ParseFromArray(slice.begin(), static_cast<int>(slice.size())));
  return response.scene_update();
}

v1::SceneUpdate Next(SceneMirror& mirror) { return UpdateIn(mirror.NextUpdate()); }

TEST(SceneMirrorTest, BeginsWithASnapshotAndMeltsCommitsTogether) {
  SceneUpdates updates(kMessage);
  SceneMirror mirror(updates);
  EXPECT_FALSE(mirror.HasUpdate());
  const auto one = With(Scene::Empty("s"), Box("a"));
  mirror.Offer(one);
  ASSERT_TRUE(mirror.HasUpdate());
  const auto snapshot = Next(mirror);
  EXPECT_TRUE(snapshot.is_snapshot());
  EXPECT_EQ(snapshot.revision(), 1u);
  EXPECT_FALSE(mirror.HasUpdate());
  auto scene = one;
  for (int i = 0; i < 10; ++i) {
    scene = With(scene, Box("a", static_cast<float>(i + 1)));
    mirror.Offer(scene);
  }
  mirror.Offer(one);  // late
  const auto update = Next(mirror);
  EXPECT_FALSE(update.is_snapshot());
  EXPECT_EQ(update.from_revision(), 1u);
  EXPECT_EQ(update.revision(), 11u);
  EXPECT_EQ(update.delta().upsert_instances_size(), 1);
  EXPECT_FALSE(mirror.HasUpdate());
}

TEST(SceneMirrorTest, AnEmptySceneHasASnapshotToo) {
  SceneUpdates updates(kMessage);
  SceneMirror mirror(updates);
  mirror.Offer(Scene::Empty("s"));
  ASSERT_TRUE(mirror.HasUpdate());
  EXPECT_TRUE(Next(mirror).is_snapshot());
  EXPECT_FALSE(mirror.HasUpdate());
}

TEST(SceneMirrorTest, OwnCommitsAreToldOnlyWhereOthersCameBetween) {
  SceneUpdates updates(kMessage);
  SceneMirror mirror(updates);
  const auto one = With(Scene::Empty("s"), Box("a"));
  mirror.Offer(one);
  mirror.NextUpdate();
  const auto own = With(one, Box("b"));
  EXPECT_TRUE(mirror.CanTellOwnCommit(own));
  EXPECT_FALSE(mirror.HasUpdate());
  const auto others = With(own, Box("c"));
  const auto own_again = With(others, Box("d"));
  EXPECT_FALSE(mirror.CanTellOwnCommit(own_again));
  const auto update = Next(mirror);
  EXPECT_EQ(update.from_revision(), 2u);
  EXPECT_EQ(update.revision(), 4u);
  EXPECT_EQ(update.delta().upsert_instances_size(), 2);
  EXPECT_TRUE(mirror.CanTellOwnCommit(own_again));
}

TEST(SceneMirrorTest, LargeChangesComeInPieces) {
  SceneUpdates updates(2048);
  SceneMirror mirror(updates);
  SceneDelta delta;
  for (int i = 0; i < 100; ++i) delta.upsert_instances.push_back(Box("box" + std::to_string(i)));
  mirror.Offer(*Scene::Empty("s")->Apply(delta));
  int pieces = 0;
  bool is_continued = true;
  while (is_continued) {
    ASSERT_TRUE(mirror.HasUpdate());
    const auto piece = Next(mirror);
    EXPECT_LE(piece.ByteSizeLong(), 2048u);
    EXPECT_EQ(piece.is_snapshot(), pieces == 0);
    is_continued = piece.is_continued();
    ++pieces;
  }
  EXPECT_GT(pieces, 5);
  EXPECT_FALSE(mirror.HasUpdate());
}

TEST(SceneUpdatesTest, AreWrittenOnceForAllAtTheSameRevision) {
  SceneUpdates updates(kMessage);
  const auto one = With(Scene::Empty("s"), Box("a"));
  const auto two = With(one, Box("b"));
  const auto first = updates.Between(one, two);
  EXPECT_EQ(updates.Between(one, two), first);
  EXPECT_NE(updates.Between(nullptr, two), first);
  EXPECT_EQ(updates.Between(nullptr, two), updates.Between(nullptr, two));
  EXPECT_TRUE(UpdateIn(updates.Between(nullptr, two)->front()).is_snapshot());
}

// A scene that is gone may have given its place in memory to another.
TEST(SceneUpdatesTest, OfASceneThatIsGoneAreNotTakenForAnothers) {
  SceneUpdates updates(kMessage);
  const auto base = With(Scene::Empty("s"), Box("a"));
  for (int i = 0; i < 300; ++i) {
    const auto next = With(base, Box("b", static_cast<float>(i)));
    const auto update = UpdateIn(updates.Between(base, next)->front());
    EXPECT_EQ(update.content_hash(), ToProto(next->content_hash()));
  }
}

}  // namespace
}  // namespace penumbra
