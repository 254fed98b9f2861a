#include "render/engine/compute_once.h"

#include <thread>

#include "gtest/gtest.h"
#include "render/engine/local_engine.h"
#include "tests/unit/engine/scripted_technique.h"

namespace penumbra::testing {
namespace {

class ComputeOnceTest : public ::testing::Test {
 protected:
  ComputeOnceTest() {
    EXPECT_TRUE(engine_.CreateScene("s").ok());
    EXPECT_TRUE(engine_.Commit("s", LampAndFloor()).ok());
  }

  ScriptedTechnique technique_;
  LocalEngine engine_{OptionsFor(technique_)};
};

TEST_F(ComputeOnceTest, ReturnsTheFinalArtifactAndReportsCoarseOnes) {
  technique_.Finish();
  const auto artifact = ComputeOnce(engine_, "s", LampOnFloor());
  ASSERT_TRUE(artifact.ok()) << artifact.status();
  EXPECT_TRUE((*artifact)->header.is_final);

  std::thread script([this] {
    technique_.AwaitJob(1);
    technique_.Pass();
  });
  int coarse = 0;
  const auto progress = [&](const Artifact& pass) {
    EXPECT_FALSE(pass.header.is_final);
    ++coarse;
    technique_.Finish();
  };
  EXPECT_TRUE(ComputeOnce(engine_, "s", LampOnFloor(), {.progress = progress}).ok());
  EXPECT_EQ(coarse, 1);
  script.join();
}

TEST_F(ComputeOnceTest, IsNotContentWithWhatOthersGotBeforeTheLastCommit) {
  UpdateLog log;
  const auto other = engine_.Subscribe("s", LampOnFloor(), log.Callback()).value();
  technique_.Finish();
  log.AwaitFinalAt(1);
  ASSERT_TRUE(engine_.Commit("s", BoxAt(0.1f)).ok());
  std::thread script([this] {
    technique_.AwaitJob(1);
    technique_.Finish();
  });
  EXPECT_EQ(ComputeOnce(engine_, "s", LampOnFloor()).value()->header.revision, 2u);
  script.join();
}

TEST_F(ComputeOnceTest, Errors) {
  EXPECT_EQ(ComputeOnce(engine_, "x", LampOnFloor()).status().code(), absl::StatusCode::kNotFound);
  ASSERT_TRUE(engine_.Commit("s", {.remove_lights = {"lamp"}}).ok());
  EXPECT_EQ(ComputeOnce(engine_, "s", LampOnFloor()).status().code(), absl::StatusCode::kNotFound);
}

TEST_F(ComputeOnceTest, StopsWhenAsked) {
  std::stop_source stop;
  std::thread script([&] {
    technique_.AwaitJob(0);
    stop.request_stop();
  });
  EXPECT_EQ(ComputeOnce(engine_, "s", LampOnFloor(), {.stop = stop.get_token()}).status().code(),
            absl::StatusCode::kCancelled);
  EXPECT_TRUE(technique_.AwaitJob(0).stop.stop_requested());
  script.join();
}

}  // namespace
}  // namespace penumbra::testing
