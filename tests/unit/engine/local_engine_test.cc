#include "render/engine/local_engine.h"

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "render/scene/field_error.h"
#include "tests/unit/engine/scripted_technique.h"

namespace penumbra::testing {
namespace {

using ::testing::HasSubstr;

void ExpectError(const absl::Status& status, absl::StatusCode code, const std::string& reason,
                 const std::string& fragment) {
  EXPECT_EQ(status.code(), code) << status;
  EXPECT_EQ(ErrorReason(status), reason);
  EXPECT_THAT(std::string(status.message()), HasSubstr(fragment));
}

class LocalEngineTest : public ::testing::Test {
 protected:
  LocalEngineOptions Options() {
    LocalEngineOptions options = OptionsFor(technique_);
    options.max_scenes = 2;
    options.max_artifacts_per_scene = 2;
    return options;
  }

  ScriptedTechnique technique_;
  LocalEngine engine_{Options()};
};

TEST_F(LocalEngineTest, ScenesComeAndGo) {
  EXPECT_TRUE(engine_.CreateScene("a").ok());
  ExpectError(engine_.CreateScene("a"), absl::StatusCode::kAlreadyExists, "DUPLICATE_ID", "'a'");
  ExpectError(engine_.CreateScene("no spaces"), absl::StatusCode::kInvalidArgument, "BAD_ID",
              "scene_id");
  EXPECT_TRUE(engine_.CreateScene("b").ok());
  ExpectError(engine_.CreateScene("c"), absl::StatusCode::kResourceExhausted, "QUOTA_SCENES",
              "fewer than 2");
  EXPECT_TRUE(engine_.DeleteScene("a").ok());
  ExpectError(engine_.DeleteScene("a"), absl::StatusCode::kNotFound, "UNKNOWN_ID", "'a'");
  EXPECT_TRUE(engine_.CreateScene("c").ok());
  const auto scenes = engine_.ListScenes().value();
  ASSERT_EQ(scenes.size(), 2u);
  EXPECT_EQ(scenes[0].id, "b");
  EXPECT_EQ(scenes[1].id, "c");
}

TEST_F(LocalEngineTest, CommitsAdvanceTheSnapshotAndRefusedOnesDoNot) {
  ASSERT_TRUE(engine_.CreateScene("a").ok());
  EXPECT_EQ(engine_.Snapshot("a").value()->revision(), 0u);
  EXPECT_EQ(engine_.Commit("a", LampAndFloor()).value(), 1u);
  const auto snapshot = engine_.Snapshot("a").value();
  SceneDelta stale = BoxAt(1);
  stale.base_revision = 0;
  ExpectError(engine_.Commit("a", stale).status(), absl::StatusCode::kAborted, "STALE_BASE", "1");
  SceneDelta half_bad = BoxAt(1);
  half_bad.remove_lights = {"nobody"};
  ExpectError(engine_.Commit("a", half_bad).status(), absl::StatusCode::kNotFound, "UNKNOWN_ID",
              "nobody");
  EXPECT_EQ(engine_.Snapshot("a").value(), snapshot) << "the same object: nothing happened";
  EXPECT_EQ(engine_.Commit("a", BoxAt(1)).value(), 2u);
  EXPECT_EQ(snapshot->revision(), 1u) << "who holds a snapshot keeps it";

  const auto info = engine_.ListScenes().value().at(0);
  EXPECT_EQ(info.revision, 2u);
  EXPECT_EQ(info.instance_count, 1u);
  EXPECT_EQ(info.light_count, 1u);
  EXPECT_EQ(info.receiver_count, 1u);
  EXPECT_EQ(info.content_hash, engine_.Snapshot("a").value()->content_hash());
}

TEST_F(LocalEngineTest, UnknownScenes) {
  ExpectError(engine_.Commit("x", {}).status(), absl::StatusCode::kNotFound, "UNKNOWN_ID", "'x'");
  ExpectError(engine_.Snapshot("x").status(), absl::StatusCode::kNotFound, "UNKNOWN_ID", "'x'");
  ExpectError(engine_.Subscribe("x", LampOnFloor(), [](const ArtifactUpdate&) {}).status(),
              absl::StatusCode::kNotFound, "UNKNOWN_ID", "'x'");
}

TEST_F(LocalEngineTest, SubscribeRefusesBadParametersAndTooManyArtifacts) {
  ASSERT_TRUE(engine_.CreateScene("a").ok());
  const auto ignore = [](const ArtifactUpdate&) {};
  ArtifactSpec none = LampOnFloor();
  none.params = SoftTextureParams{.samples = 0};
  ExpectError(engine_.Subscribe("a", none, ignore).status(), absl::StatusCode::kInvalidArgument,
              "RANGE", "samples");
  const auto first = engine_.Subscribe("a", LampOnFloor(1), ignore).value();
  auto second = engine_.Subscribe("a", LampOnFloor(2), ignore).value();
  const auto first_again = engine_.Subscribe("a", LampOnFloor(1), ignore);
  EXPECT_TRUE(first_again.ok()) << "shared, not another";
  ExpectError(engine_.Subscribe("a", LampOnFloor(3), ignore).status(),
              absl::StatusCode::kResourceExhausted, "QUOTA_ARTIFACTS", "at most 2");
  second.reset();
  EXPECT_TRUE(engine_.Subscribe("a", LampOnFloor(3), ignore).ok());
}

TEST(SceneMemoryTest, IsOneForTheArtifactsOfOneScene) {
  const FunctionTechnique technique([](const Scene& scene, const ArtifactSpec&,
                                       const ComputeContext& context) -> absl::StatusOr<Artifact> {
    Artifact artifact = LabelledArtifact(scene, 0, true);
    artifact.header.parameters["memory"] =
        absl::StrCat(absl::Hex(reinterpret_cast<uintptr_t>(context.memory->of_scene.get())));
    return artifact;
  });
  LocalEngine engine(OptionsFor(technique));
  const auto memory_of = [&](const std::string& scene_id, uint64_t seed) {
    UpdateLog log;
    const auto subscription = engine.Subscribe(scene_id, LampOnFloor(seed), log.Callback()).value();
    return log.AwaitCount(1)[0].artifact->header.parameters.at("memory");
  };
  for (const char* id : {"a", "b"}) {
    ASSERT_TRUE(engine.CreateScene(id).ok());
    ASSERT_TRUE(engine.Commit(id, LampAndFloor()).ok());
  }
  EXPECT_NE(memory_of("a", 1), "0");
  EXPECT_EQ(memory_of("a", 1), memory_of("a", 2));
  EXPECT_NE(memory_of("a", 1), memory_of("b", 1));
}

}  // namespace
}  // namespace penumbra::testing
