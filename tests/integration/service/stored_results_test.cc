// Artifacts that outlive their server, and are not computed twice.

#include "server/results/stored_results.h"

#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include "render/engine/compute_once.h"
#include "render/engine/local_engine.h"
#include "render/scene/hashed_text.h"
#include "server/results/result_origin.h"
#include "tests/integration/service/durable_scenes.h"
#include "tests/support/random_width_map.h"

namespace penumbra::testing {
namespace {

namespace fs = std::filesystem;

using google::protobuf::util::MessageDifferencer;

class KnownResultsTest : public DurableScenesTest {
 protected:
  KnownResultsTest() { options_.results = {.memory_bytes = 64u << 20, .disk_bytes = 64u << 20}; }

  std::string ResultsFolder() { return folder_ / "data/results"; }
  size_t FileCount() {
    size_t count = 0;
    for (const auto& file : fs::directory_iterator(ResultsFolder())) {
      count += file.is_regular_file();
    }
    return count;
  }
  bool AwaitFiles(size_t count) {
    for (int i = 0; i < 200 && FileCount() < count; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return FileCount() == count;
  }
  uint64_t jobs_started() { return client_->ServerInfo().statistics().jobs_started(); }
  ArtifactUpdate Look(Revision revision, const std::string& scene_id = "studio") {
    const auto session = client_->OpenSession(scene_id);
    EXPECT_EQ(session->Subscribe(1, FloorSpec(), 8), absl::OkStatus());
    return session->AwaitUpdate(1, FinalAt(revision));
  }
};

TEST_F(KnownResultsTest, ARestartedServerReadsWhatItComputedBefore) {
  Restart();
  MakeStudio();
  const ArtifactUpdate before = Look(1);
  ASSERT_TRUE(before.artifact);
  EXPECT_TRUE(AwaitFiles(1));
  Restart();
  const ArtifactUpdate after = Look(1);
  ASSERT_TRUE(after.artifact);
  EXPECT_EQ(TextureOf(after).visibility.counts, TextureOf(before).visibility.counts);
  EXPECT_EQ(after.artifact->header.light_samples, before.artifact->header.light_samples);
  EXPECT_EQ(after.artifact->header.parameters, before.artifact->header.parameters);
  EXPECT_TRUE(after.artifact->header.timings_ms.empty()) << "nothing was computed";
}

TEST_F(KnownResultsTest, WhatIsDamagedIsComputedAgain) {
  Restart();
  MakeStudio();
  const ArtifactUpdate before = Look(1);
  ASSERT_TRUE(AwaitFiles(1));
  server_.reset();
  for (const auto& file : fs::directory_iterator(ResultsFolder())) {
    fs::resize_file(file.path(), file.file_size() / 2);
  }
  Restart();
  const ArtifactUpdate after = Look(1);
  ASSERT_TRUE(after.artifact);
  EXPECT_FALSE(after.artifact->header.timings_ms.empty()) << "computed";
  EXPECT_EQ(TextureOf(after).visibility.counts, TextureOf(before).visibility.counts);
}

TEST_F(KnownResultsTest, OfADragTheRestIsStored) {
  Restart();
  MakeStudio();
  ASSERT_EQ(session_->Subscribe(1, FloorSpec(), 1000), absl::OkStatus());
  for (int i = 0; i < 20; ++i) {
    const Revision revision = session_->Commit(MoveBox({0, 1, 0.05f * i})).revision();
    session_->AwaitUpdate(1, FinalAt(revision));
  }
  ASSERT_TRUE(AwaitFiles(1));
  std::this_thread::sleep_for(std::chrono::milliseconds(2'500));
  EXPECT_EQ(FileCount(), 1u) << "nothing on the way there";
}

TEST_F(KnownResultsTest, AnotherSceneThatIsEqualIsNotComputed) {
  Restart();
  MakeStudio();
  const ArtifactUpdate first = Look(1);
  MakeStudio("copy");
  const uint64_t jobs = jobs_started();
  const ArtifactUpdate second = Look(1, "copy");
  ASSERT_TRUE(second.artifact);
  EXPECT_EQ(jobs_started(), jobs);
  EXPECT_EQ(second.artifact->header.scene_id, "copy");
  EXPECT_EQ(TextureOf(second).visibility.counts, TextureOf(first).visibility.counts);
}

TEST_F(KnownResultsTest, AFolderThatCannotBeUsedCostsNothingElse) {
  Restart();
  MakeStudio();
  server_.reset();
  fs::remove_all(ResultsFolder());
  { std::ofstream(ResultsFolder()) << "no folder"; }
  Restart();
  EXPECT_TRUE(Look(1).artifact);
}

class StoredResultsTest : public ::testing::Test {
 protected:
  std::unique_ptr<StoredResults> Open(const std::string& origin = "here") {
    auto results = StoredResults::Open({.folder = folder_ / "results",
                                        .max_bytes = 64u << 20,
                                        .origin = origin,
                                        .rest = std::chrono::seconds(60)},
                                       QuietLogger());
    EXPECT_TRUE(results.ok()) << results.status();
    return *std::move(results);
  }

  const TemporaryFolder folder_;
  const ContentHash key_ = {.bytes = {1, 2, 3}};
};

// All that a client without anything gets, but for times.
v1::ArtifactUpdate AsSent(std::shared_ptr<const Artifact> artifact) {
  ArtifactEncoder encoder;
  const auto encoded = encoder.Encode(nullptr, std::move(artifact), 1);
  std::string bytes;
  const auto add = [&bytes](const grpc::Slice& slice) {
    bytes.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
  };
  add(encoded->header);
  add(encoded->light_samples);
  for (const EncodedTile& tile : encoded->tiles) add(tile.bytes);
  v1::ArtifactUpdate update;
  EXPECT_TRUE(update.ParseFromString(bytes));
  update.mutable_header()->clear_timings_ms();
  return update;
}

TEST_F(StoredResultsTest, AnArtifactOfEachTechniqueComesBackAsItWas) {
  LocalEngine engine;
  ASSERT_TRUE(engine.CreateScene("studio").ok());
  ASSERT_TRUE(engine.Commit("studio", StudioDelta()).ok());
  const SoftTextureParams shaded{
      .samples = 16, .radiance = true, .output = RadianceFormat::kUnorm16, .output_scale = 2};
  const PicturePixels picture{
      .camera = {.eye = {3, 3, 3}, .target = {0, 0, 0}}, .width = 64, .height = 48};
  const ArtifactSpec specs[] = {
      FloorSpec(),
      {.params = shaded, .light_id = "lamp", .receiver_id = "floor"},
      {.params = LayeredAttenuationParams{.samples = 16, .resolution = 64}, .light_id = "lamp"},
      {.params = CoherentRaytraceParams{.samples = 4}, .light_id = "lamp", .points = picture},
      {.params = ShadowWidthParams{.resolution = 64}, .light_id = "lamp"},
      {.params = ShadowVolumeParams{.resolution = 64}, .light_id = "lamp"}};
  for (const ArtifactSpec& spec : specs) {
    const std::string key_text = SpecKey(spec);
    const auto artifact = ComputeOnce(engine, "studio", spec);
    ASSERT_TRUE(artifact.ok()) << key_text << artifact.status();
    const ContentHash key = HashOfBytes(key_text);
    Open()->Save("slot", key, *artifact);
    const auto loaded = Open()->Load(key);
    ASSERT_TRUE(loaded) << key_text;
    EXPECT_TRUE(MessageDifferencer::Equals(AsSent(loaded), AsSent(*artifact))) << key_text;
    EXPECT_TRUE(loaded->header.timings_ms.empty()) << key_text;
  }
}

TEST_F(StoredResultsTest, AreFoundByTheirOriginAndKeyAlone) {
  Artifact artifact;
  artifact.payload = RandomWidthMap(3, /*has_far=*/true);
  Open()->Save("slot", key_, std::make_shared<const Artifact>(std::move(artifact)));
  EXPECT_TRUE(Open()->Load(key_)) << "written when the server ended";
  EXPECT_FALSE(Open("elsewhere")->Load(key_));
  EXPECT_FALSE(Open()->Load({.bytes = {9}}));
}

TEST(ResultOriginTest, IsOfTheDeviceAndOtherwiseTheSame) {
  v1::GlInfo one, other;
  one.set_renderer("one");
  other.set_renderer("other");
  EXPECT_EQ(ResultOrigin(one), ResultOrigin(one));
  EXPECT_NE(ResultOrigin(one), ResultOrigin(other));
}

}  // namespace
}  // namespace penumbra::testing
