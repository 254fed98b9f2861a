#include "server/session/scene_mirror.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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

TEST(SceneMirrorTest, BeginsWithASnapshotAndMeltsCommitsTogether) {
  SceneMirror mirror(kMessage);
  EXPECT_FALSE(mirror.HasUpdate());
  const auto one = With(Scene::Empty("s"), Box("a"));
  mirror.Offer(one);
  ASSERT_TRUE(mirror.HasUpdate());
  const auto snapshot = mirror.NextUpdate();
  EXPECT_TRUE(snapshot.is_snapshot());
  EXPECT_EQ(snapshot.revision(), 1u);
  EXPECT_FALSE(mirror.HasUpdate());
  auto scene = one;
  for (int i = 0; i < 10; ++i) {
    scene = With(scene, Box("a", static_cast<float>(i + 1)));
    mirror.Offer(scene);
  }
  mirror.Offer(one);  // late
  const auto update = mirror.NextUpdate();
  EXPECT_FALSE(update.is_snapshot());
  EXPECT_EQ(update.from_revision(), 1u);
  EXPECT_EQ(update.revision(), 11u);
  EXPECT_EQ(update.delta().upsert_instances_size(), 1);
  EXPECT_FALSE(mirror.HasUpdate());
}

TEST(SceneMirrorTest, AnEmptySceneHasASnapshotToo) {
  SceneMirror mirror(kMessage);
  mirror.Offer(Scene::Empty("s"));
  ASSERT_TRUE(mirror.HasUpdate());
  EXPECT_TRUE(mirror.NextUpdate().is_snapshot());
  EXPECT_FALSE(mirror.HasUpdate());
}

TEST(SceneMirrorTest, OwnCommitsAreToldOnlyWhereOthersCameBetween) {
  SceneMirror mirror(kMessage);
  const auto one = With(Scene::Empty("s"), Box("a"));
  mirror.Offer(one);
  mirror.NextUpdate();
  const auto own = With(one, Box("b"));
  EXPECT_TRUE(mirror.CanTellOwnCommit(own));
  EXPECT_FALSE(mirror.HasUpdate());
  const auto others = With(own, Box("c"));
  const auto own_again = With(others, Box("d"));
  EXPECT_FALSE(mirror.CanTellOwnCommit(own_again));
  const auto update = mirror.NextUpdate();
  EXPECT_EQ(update.from_revision(), 2u);
  EXPECT_EQ(update.revision(), 4u);
  EXPECT_EQ(update.delta().upsert_instances_size(), 2);
  EXPECT_TRUE(mirror.CanTellOwnCommit(own_again));
}

TEST(SceneMirrorTest, LargeChangesComeInPieces) {
  SceneMirror mirror(2048);
  SceneDelta delta;
  for (int i = 0; i < 100; ++i) delta.upsert_instances.push_back(Box("box" + std::to_string(i)));
  mirror.Offer(*Scene::Empty("s")->Apply(delta));
  int pieces = 0;
  bool is_continued = true;
  while (is_continued) {
    ASSERT_TRUE(mirror.HasUpdate());
    const auto piece = mirror.NextUpdate();
    EXPECT_LE(piece.ByteSizeLong(), 2048u);
    EXPECT_EQ(piece.is_snapshot(), pieces == 0);
    is_continued = piece.is_continued();
    ++pieces;
  }
  EXPECT_GT(pieces, 5);
  EXPECT_FALSE(mirror.HasUpdate());
}

}  // namespace
}  // namespace penumbra
