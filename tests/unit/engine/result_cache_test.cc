#include "render/engine/result_cache.h"

#include <gtest/gtest.h>

#include <atomic>
#include <map>
#include <mutex>
#include <string>
#include <utility>

#include "render/engine/compute_once.h"
#include "render/engine/local_engine.h"
#include "render/scene/hashed_text.h"
#include "tests/unit/engine/scripted_technique.h"

namespace penumbra::testing {
namespace {

constexpr size_t kKibibyte = 1024;

ContentHash Key(int number) { return HashedText().Add(static_cast<uint64_t>(number)).Hash(); }

// Of `bytes` and a little more.
std::shared_ptr<const Artifact> ArtifactOf(size_t bytes) {
  Artifact artifact;
  SoftShadowTexture texture;
  texture.visibility.counts.resize(bytes / sizeof(uint16_t));
  artifact.payload = std::move(texture);
  return std::make_shared<const Artifact>(std::move(artifact));
}

class MapStore : public ResultStore {
 public:
  std::shared_ptr<const Artifact> Load(const ContentHash& key) override {
    std::lock_guard lock(mutex_);
    const auto found = results_.find(key);
    return found == results_.end() ? nullptr : found->second;
  }
  void Save(const std::string& slot, const ContentHash& key,
            std::shared_ptr<const Artifact> artifact) override {
    std::lock_guard lock(mutex_);
    results_[key] = std::move(artifact);
    slots_[slot] = key;
  }
  size_t slot_count() {
    std::lock_guard lock(mutex_);
    return slots_.size();
  }

 private:
  std::mutex mutex_;
  std::map<ContentHash, std::shared_ptr<const Artifact>> results_;
  std::map<std::string, ContentHash> slots_;
};

TEST(ResultCacheTest, WhatWasUnusedForLongestGoesFirst) {
  ResultCache results({.max_bytes = 40 * kKibibyte});
  for (int i = 0; i < 4; ++i) results.Keep("slot", Key(i), ArtifactOf(8 * kKibibyte));
  EXPECT_TRUE(results.FindInMemory(Key(0))) << "used now";
  results.Keep("slot", Key(4), ArtifactOf(8 * kKibibyte));
  EXPECT_TRUE(results.FindInMemory(Key(0)));
  EXPECT_FALSE(results.FindInMemory(Key(1)));
  for (int i = 2; i < 5; ++i) EXPECT_TRUE(results.FindInMemory(Key(i))) << i;
  EXPECT_LE(results.statistics().bytes, 40 * kKibibyte);
  EXPECT_EQ(results.statistics().found_in_memory, 5u);
}

TEST(ResultCacheTest, OneArtifactDoesNotPushOutAllOthers) {
  ResultCache results({.max_bytes = 40 * kKibibyte});
  results.Keep("slot", Key(0), ArtifactOf(8 * kKibibyte));
  results.Keep("slot", Key(1), ArtifactOf(10 * kKibibyte));
  EXPECT_TRUE(results.FindInMemory(Key(0)));
  EXPECT_FALSE(results.FindInMemory(Key(1))) << "more than a quarter";
}

TEST(ResultCacheTest, WhatComesTwiceCountsOnce) {
  ResultCache results({.max_bytes = 40 * kKibibyte});
  results.Keep("slot", Key(0), ArtifactOf(8 * kKibibyte));
  const size_t bytes = results.statistics().bytes;
  results.Keep("slot", Key(0), ArtifactOf(8 * kKibibyte));
  EXPECT_EQ(results.statistics().bytes, bytes);
}

TEST(ResultCacheTest, WhatTheStoreHasIsInMemoryAfterwards) {
  MapStore store;
  ResultCache results({.max_bytes = 40 * kKibibyte, .store = &store});
  store.Save("slot", Key(7), ArtifactOf(kKibibyte));
  EXPECT_FALSE(results.FindInMemory(Key(7)));
  EXPECT_TRUE(results.FindAnywhere(Key(7)));
  EXPECT_TRUE(results.FindInMemory(Key(7)));
  EXPECT_FALSE(results.FindAnywhere(Key(8)));
  const ResultStatistics statistics = results.statistics();
  EXPECT_EQ(statistics.found_in_store, 1u);
  EXPECT_EQ(statistics.not_found, 1u);
}

// Engines whose technique says how often it was asked.
class RecallTest : public ::testing::Test {
 protected:
  LocalEngineOptions Options() {
    LocalEngineOptions options = OptionsFor(technique_);
    options.results = {.max_bytes = size_t{1} << 20, .store = &store_};
    return options;
  }
  void MakeScene(const std::string& id) {
    ASSERT_TRUE(engine_.CreateScene(id).ok());
    ASSERT_TRUE(engine_.Commit(id, LampAndFloor()).ok());
  }
  ArtifactHeader Compute(const std::string& id) {
    const auto artifact = ComputeOnce(engine_, id, LampOnFloor());
    EXPECT_TRUE(artifact.ok()) << artifact.status();
    return artifact.ok() ? (*artifact)->header : ArtifactHeader();
  }

  std::atomic<int> computed_ = 0;
  FunctionTechnique technique_{
      [this](const Scene& scene, const ArtifactSpec&, const ComputeContext&) {
        ++computed_;
        return absl::StatusOr<Artifact>(LabelledArtifact(scene, 0, true));
      }};
  MapStore store_;
  LocalEngine engine_{Options()};
};

TEST_F(RecallTest, AnEditThatIsUndoneIsNotComputedAgain) {
  MakeScene("s");
  UpdateLog log;
  const auto subscription = engine_.Subscribe("s", LampOnFloor(), log.Callback()).value();
  log.AwaitFinalAt(1);
  ASSERT_EQ(engine_.Commit("s", BoxAt(0.1f)).value(), 2u);
  log.AwaitFinalAt(2);
  ASSERT_EQ(engine_.Commit("s", BoxAt(0)).value(), 3u);
  const ArtifactHeader again = log.AwaitFinalAt(3).back().artifact->header;
  EXPECT_EQ(computed_, 2);
  EXPECT_EQ(again.revision, 3u) << "as if it had been computed on it";
  EXPECT_EQ(again.scene_hash, engine_.Snapshot("s").value()->content_hash());
}

TEST_F(RecallTest, WhoComesBackIsAnsweredAtOnceAndWithoutAJob) {
  MakeScene("s");
  Compute("s");
  const uint64_t jobs = engine_.statistics().jobs_started;
  Compute("s");
  EXPECT_EQ(engine_.statistics().jobs_started, jobs);
  EXPECT_EQ(computed_, 1);
}

TEST_F(RecallTest, EqualScenesShare) {
  MakeScene("a");
  MakeScene("b");
  Compute("a");
  ASSERT_EQ(engine_.Commit("b", {}).value(), 2u);
  const ArtifactHeader of_b = Compute("b");
  EXPECT_EQ(computed_, 1);
  EXPECT_EQ(of_b.scene_id, "b");
  EXPECT_EQ(of_b.revision, 2u);
}

TEST_F(RecallTest, WhatAnotherEngineStoredIsFound) {
  MakeScene("s");
  Compute("s");
  LocalEngine other(Options());
  ASSERT_TRUE(other.CreateScene("s").ok());
  ASSERT_TRUE(other.Commit("s", LampAndFloor()).ok());
  EXPECT_TRUE(ComputeOnce(other, "s", LampOnFloor()).ok());
  EXPECT_EQ(computed_, 1);
  EXPECT_EQ(other.result_statistics().found_in_store, 1u);
}

TEST_F(RecallTest, OneArtifactOfOneSceneHasOneSlot) {
  MakeScene("s");
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(engine_.Commit("s", BoxAt(0.1f * i)).ok());
    Compute("s");
  }
  EXPECT_EQ(store_.slot_count(), 1u);
}

TEST_F(RecallTest, WhatTheCpuMadeForGlIsNotKept) {
  const FunctionTechnique without_gl(
      [this](const Scene& scene, const ArtifactSpec&, const ComputeContext&) {
        ++computed_;
        Artifact artifact = LabelledArtifact(scene, 0, true);
        artifact.header.parameters["without_gl"] = "lost";
        return absl::StatusOr<Artifact>(std::move(artifact));
      });
  LocalEngineOptions options = OptionsFor(without_gl);
  options.results = {.max_bytes = size_t{1} << 20};
  LocalEngine engine(options);
  ASSERT_TRUE(engine.CreateScene("s").ok());
  ASSERT_TRUE(engine.Commit("s", LampAndFloor()).ok());
  for (int i = 0; i < 2; ++i) EXPECT_TRUE(ComputeOnce(engine, "s", LampOnFloor()).ok());
  EXPECT_EQ(computed_, 2);
}

}  // namespace
}  // namespace penumbra::testing
