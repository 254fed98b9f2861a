// Shadow-width maps by way of a server.
#include "render/artifact/shadow_width_map.h"
#include "tests/integration/session/remote_engine_fixture.h"

namespace penumbra::testing {
namespace {

SceneDelta StudioOnAFloor(Vec3 box_position) {
  SceneDelta delta = Studio(box_position);
  delta.upsert_instances.push_back({.id = "ground",
                                    .mesh = MeshOf(UnitSquareGeometry()),
                                    .world_from_mesh = Placed(Vec3(0), Vec3(2, 1, 2))});
  return delta;
}

const ShadowWidthMap& MapOf(const Artifact& artifact) {
  return std::get<ShadowWidthMap>(artifact.payload);
}

void ExpectSame(const Artifact& found, const SceneDelta& delta, const ArtifactSpec& spec) {
  LocalEngine local(LocalEngineOptions{});
  ASSERT_TRUE(local.CreateScene("s").ok());
  ASSERT_TRUE(local.Commit("s", delta).ok());
  const auto expected = ComputeOnce(local, "s", spec).value();
  ASSERT_EQ(MapOf(found).faces.size(), MapOf(*expected).faces.size());
  for (size_t f = 0; f < MapOf(found).faces.size(); ++f) {
    const ShadowWidthFace &one = MapOf(found).faces[f], &other = MapOf(*expected).faces[f];
    EXPECT_EQ(one.near.depths, other.near.depths);
    EXPECT_EQ(one.near.widths, other.near.widths);
    ASSERT_EQ(one.far.has_value(), other.far.has_value());
    if (!one.far) continue;
    EXPECT_EQ(one.far->depths, other.far->depths);
    EXPECT_EQ(one.far->widths, other.far->widths);
  }
  EXPECT_EQ(found.header.light_samples, expected->header.light_samples);
  EXPECT_EQ(found.header.parameters, expected->header.parameters);
}

TEST_F(RemoteEngineTest, WidthsArriveAsTheyWereComputed) {
  const ArtifactSpec spec{ShadowWidthParams{.resolution = 300}, "lamp"};
  auto engine = Connect();
  ASSERT_TRUE(engine->CreateScene("s").ok());
  ASSERT_TRUE(engine->Commit("s", StudioOnAFloor(Vec3(0, 0.5f, 0))).ok());
  Inbox inbox;
  const auto subscription = engine->Subscribe("s", spec, inbox.callback());
  ASSERT_TRUE(subscription.ok()) << subscription.status();
  auto update = inbox.WaitForFinal(1);
  ASSERT_TRUE(update);
  ExpectSame(*update->artifact, StudioOnAFloor(Vec3(0, 0.5f, 0)), spec);
  EXPECT_LT(Visibility(*update->artifact, Vec3(0, 0, 0), Vec3(0, 1, 0)), 0.5f);
  EXPECT_EQ(Visibility(*update->artifact, Vec3(1.8f, 0, 1.8f), Vec3(0, 1, 0)), 1.0f);
  // After an edit it is that of the new scene, from the tiles that changed.
  ASSERT_TRUE(engine->Commit("s", StudioOnAFloor(Vec3(0.7f, 0.5f, 0))).ok());
  update = inbox.WaitForFinal(2);
  ASSERT_TRUE(update);
  ExpectSame(*update->artifact, StudioOnAFloor(Vec3(0.7f, 0.5f, 0)), spec);
}

// A coarse map, other faces and all, before the one that was asked for.
TEST_F(RemoteEngineTest, ALargeWidthMapComesCoarseFirst) {
  auto engine = Connect();
  ASSERT_TRUE(engine->CreateScene("s").ok());
  ASSERT_TRUE(engine->Commit("s", StudioOnAFloor(Vec3(0, 0.5f, 0))).ok());
  Inbox inbox;
  const auto subscription =
      engine->Subscribe("s", {ShadowWidthParams{.resolution = 1024}, "lamp"}, inbox.callback());
  ASSERT_TRUE(subscription.ok()) << subscription.status();
  const auto update = inbox.WaitForFinal(1);
  ASSERT_TRUE(update);
  EXPECT_EQ(update->artifact->header.parameters.at("resolution"), "1024");
  EXPECT_EQ(inbox.updates().front().artifact->header.parameters.at("resolution"), "256");
}

}  // namespace
}  // namespace penumbra::testing
