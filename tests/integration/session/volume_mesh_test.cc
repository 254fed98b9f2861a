// Shadow volume meshes by way of a server.
#include "render/artifact/shadow_volume_mesh.h"
#include "tests/integration/session/remote_engine_fixture.h"

namespace penumbra::testing {
namespace {

SceneDelta StudioOnAFloor(Vec3 box_position) {
  SceneDelta delta = Studio(box_position);
  delta.upsert_instances.push_back({.id = "ground",
                                    .mesh = MeshOf(UnitSquareGeometry()),
                                    .world_from_mesh = Placed(Vec3(0), Vec3(2, 1, 2))});
  for (int i = 0; i < 6; ++i) {
    delta.upsert_instances.push_back(
        {.id = "ball" + std::to_string(i),
         .mesh = MeshOf(BallGeometry(96, 48)),
         .world_from_mesh = Placed(Vec3(0.5f * static_cast<float>(i) - 1.2f, 0.2f, 1.2f), 0.15f)});
  }
  return delta;
}

const ShadowVolumeMesh& VolumesOfArtifact(const Artifact& artifact) {
  return std::get<ShadowVolumeMesh>(artifact.payload);
}

void ExpectSame(const Artifact& found, const SceneDelta& delta, const ArtifactSpec& spec) {
  LocalEngine local(LocalEngineOptions{});
  ASSERT_TRUE(local.CreateScene("s").ok());
  ASSERT_TRUE(local.Commit("s", delta).ok());
  const auto expected = ComputeOnce(local, "s", spec).value();
  const auto &one = VolumesOfArtifact(found).volumes, &other = VolumesOfArtifact(*expected).volumes;
  ASSERT_EQ(one.size(), other.size());
  for (size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i]->instance_id, other[i]->instance_id);
    EXPECT_EQ(one[i]->content, other[i]->content);
    EXPECT_EQ(one[i]->vertices, other[i]->vertices);
    EXPECT_EQ(one[i]->indices, other[i]->indices);
    EXPECT_EQ(one[i]->weights, other[i]->weights);
    EXPECT_EQ(one[i]->caster_indices, other[i]->caster_indices);
    ASSERT_EQ(one[i]->faces.size(), other[i]->faces.size());
    for (size_t f = 0; f < one[i]->faces.size(); ++f) {
      EXPECT_EQ(one[i]->faces[f].map.depths, other[i]->faces[f].map.depths);
    }
  }
  EXPECT_EQ(found.header.light_samples, expected->header.light_samples);
  EXPECT_EQ(found.header.parameters, expected->header.parameters);
}

class VolumeMeshTest : public RemoteEngineTest {
 protected:
  // Commits a scene, moves its box, and holds both that is received against what is computed here.
  // Returns how many volumes of the first are those of the second too.
  size_t MoveTheBox(const ShadowVolumeParams& params) {
    const ArtifactSpec spec{params, "lamp"};
    const std::string scene = "scene" + std::to_string(++scenes_);
    auto engine = Connect();
    EXPECT_TRUE(engine->CreateScene(scene).ok());
    EXPECT_TRUE(engine->Commit(scene, StudioOnAFloor(Vec3(0, 0.5f, 0))).ok());
    Inbox inbox;
    const auto subscription = engine->Subscribe(scene, spec, inbox.callback());
    EXPECT_TRUE(subscription.ok()) << subscription.status();
    const auto before = inbox.WaitForFinal(1);
    if (!before) return 0;
    ExpectSame(*before->artifact, StudioOnAFloor(Vec3(0, 0.5f, 0)), spec);
    EXPECT_EQ(Visibility(*before->artifact, Vec3(0, 0.01f, 0), Vec3(0, 1, 0)), 0.0f);
    EXPECT_EQ(Visibility(*before->artifact, Vec3(1.8f, 0, 1.8f), Vec3(0, 1, 0)), 1.0f);
    EXPECT_TRUE(engine->Commit(scene, StudioOnAFloor(Vec3(0.1f, 0.5f, 0))).ok());
    const auto after = inbox.WaitForFinal(2);
    if (!after) return 0;
    ExpectSame(*after->artifact, StudioOnAFloor(Vec3(0.1f, 0.5f, 0)), spec);
    size_t shared = 0;
    for (const auto& volume : VolumesOfArtifact(*before->artifact).volumes) {
      for (const auto& other : VolumesOfArtifact(*after->artifact).volumes)
        shared += volume == other;
    }
    return shared;
  }

 private:
  int scenes_ = 0;
};

TEST_F(VolumeMeshTest, ArriveAsTheyWereComputed) {
  EXPECT_EQ(MoveTheBox({.resolution = 300}), 0u);
  EXPECT_EQ(MoveTheBox({.resolution = 300, .surface = VolumeSurface::kLines}), 0u);
}

// The ground's and the balls' volumes are not sent again, and are the same objects as before.
TEST_F(VolumeMeshTest, VolumesThatDidNotChangeAreShared) {
  EXPECT_EQ(MoveTheBox({.resolution = 300, .volumes_of = VolumesOf::kInstances}), 7u);
  EXPECT_EQ(MoveTheBox({.resolution = 300, .volumes_of = VolumesOf::kEdges}), 7u);
}

TEST_F(VolumeMeshTest, ALargeMapComesCoarseFirst) {
  auto engine = Connect();
  ASSERT_TRUE(engine->CreateScene("s").ok());
  ASSERT_TRUE(engine->Commit("s", StudioOnAFloor(Vec3(0, 0.5f, 0))).ok());
  Inbox inbox;
  const auto subscription =
      engine->Subscribe("s", {ShadowVolumeParams{.resolution = 1024}, "lamp"}, inbox.callback());
  ASSERT_TRUE(subscription.ok()) << subscription.status();
  const auto update = inbox.WaitForFinal(1);
  ASSERT_TRUE(update);
  EXPECT_EQ(update->artifact->header.parameters.at("resolution"), "1024");
  EXPECT_EQ(inbox.updates().front().artifact->header.parameters.at("resolution"), "256");
}

}  // namespace
}  // namespace penumbra::testing
