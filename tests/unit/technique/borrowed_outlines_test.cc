// Outlines borrowed from neighbouring light samples: nearly right, by as much as is reported.
#include "render/technique/soft_texture/borrowed_outlines.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/support/rippled_torus.h"
#include "tests/unit/technique/soft_texture_scenes.h"

namespace penumbra::testing {
namespace {

constexpr uint32_t kTexels = 128;

// A torus over a floor, between boxes.
std::shared_ptr<const Scene> TorusScene() {
  SceneDelta delta = RandomBoxes(4, 3);
  delta.upsert_instances.push_back({.id = "torus",
                                    .mesh = MeshOf(RippledTorus(160, 40)),
                                    .world_from_mesh = Placed(Vec3(0, 1.5f, 0), 0.8f)});
  delta.upsert_lights = {Ceiling()};
  delta.upsert_receivers = {Floor(kTexels, kTexels)};
  return SceneOf(delta);
}

Artifact Borrowed(const Scene& scene, uint32_t reuse, int threads = 2) {
  return Compute(
             scene,
             {.samples = 64, .method = VisibilityMethod::kSilhouette, .silhouette_reuse = reuse},
             threads)
      .value();
}

double ReportedError(const Artifact& artifact) {
  return std::stod(artifact.header.parameters.at("silhouette_reuse_error"));
}

const std::vector<uint16_t>& CountsOf(const Artifact& artifact) {
  return TextureOf(artifact).visibility.counts;
}

// Of all samples together, as a part of texel-samples.
double MeanDifference(const Artifact& a, const Artifact& b) {
  double sum = 0;
  for (size_t t = 0; t < CountsOf(a).size(); ++t) sum += std::abs(CountsOf(a)[t] - CountsOf(b)[t]);
  return sum / 64 / static_cast<double>(CountsOf(a).size());
}

TEST(BorrowedOutlines, AreNearlyRightAndSayHowNearly) {
  const auto scene = TorusScene();
  const Artifact exact = Borrowed(*scene, 1);
  EXPECT_FALSE(exact.header.parameters.contains("silhouette_reuse_error"));
  double last = 0;
  for (const uint32_t reuse : {2, 8, 64}) {
    const Artifact borrowed = Borrowed(*scene, reuse);
    EXPECT_EQ(borrowed.header.parameters.at("silhouette_reuse"), std::to_string(reuse));
    const double difference = MeanDifference(borrowed, exact);
    EXPECT_GT(difference, 0) << reuse;
    EXPECT_LT(difference, 0.02) << reuse;
    // The samples that were looked at are those furthest off.
    EXPECT_GE(ReportedError(borrowed), difference) << reuse;
    EXPECT_LT(ReportedError(borrowed), 0.1) << reuse;
    EXPECT_GT(ReportedError(borrowed), last) << reuse;
    last = ReportedError(borrowed);
  }
}

TEST(BorrowedOutlines, ChangeNothingOfWhatHasNone) {
  const auto scene = TorusScene();
  const auto counts = [&](uint32_t reuse) {
    return Compute(*scene, {.method = VisibilityMethod::kCoverage, .silhouette_reuse = reuse})
        .value();
  };
  EXPECT_EQ(CountsOf(counts(8)), CountsOf(counts(1)));
  EXPECT_EQ(ReportedError(counts(8)), 0);
}

TEST(BorrowedOutlines, AreTheSameForAnyThreadsPassesAndEdits) {
  const auto scene = TorusScene();
  const Artifact one = Borrowed(*scene, 8, 1);
  EXPECT_EQ(CountsOf(Borrowed(*scene, 8, 4)), CountsOf(one));
  tbb::task_arena arena(2);
  const ArtifactSpec spec{
      SoftTextureParams{
          .samples = 64, .method = VisibilityMethod::kSilhouette, .silhouette_reuse = 8},
      "light", "floor"};
  MemoryBudget budget(size_t{64} << 20);
  TechniqueMemory memory{budget};
  int passes = 0;
  const ComputeContext context{
      .arena = arena,
      .progress =
          [&](const Artifact& pass) {
            ++passes;
            EXPECT_FALSE(pass.header.parameters.contains("silhouette_reuse_error"));
          },
      .memory = &memory};
  const Technique& technique = TechniqueFor(spec.params);
  EXPECT_EQ(CountsOf(technique.Compute(*scene, spec, context).value()), CountsOf(one));
  EXPECT_GT(passes, 0);
  // What is drawn over the kept shadows of the torus, and then with it moved.
  auto edited = scene;
  for (const char* id : {"box1", "torus", "box1"}) {
    Instance moved = *edited->FindInstance(id);
    moved.world_from_mesh[3] += Vec3(0.1f, 0, 0.05f);
    edited = edited->Apply({.upsert_instances = {moved}}).value();
    EXPECT_EQ(CountsOf(technique.Compute(*edited, spec, context).value()),
              CountsOf(Borrowed(*edited, 8)))
        << id;
  }
}

TEST(BorrowedOutlines, AreLentByTheMiddleOfAGroup) {
  const AreaLight light = Ceiling();
  const std::vector<LightSample> samples = SampleLight(light, 64, 1, Vec3(0.0f));
  const auto lenders = OutlineLenders(samples, 8);
  ASSERT_EQ(lenders.size(), 64u);
  std::set<std::pair<float, float>> places;
  for (size_t s = 0; s < 64; ++s) {
    places.insert({lenders[s].point.x, lenders[s].point.z});
    EXPECT_LT(glm::length(lenders[s].point - samples[s].point), 1.0f) << s;
  }
  EXPECT_GE(places.size(), 8u);
  EXPECT_LE(places.size(), 16u);
  const auto furthest = FurthestFromLenders(samples, lenders, 4);
  ASSERT_EQ(furthest.size(), 4u);
  const auto distance = [&](size_t s) { return glm::length(lenders[s].point - samples[s].point); };
  for (size_t s = 0; s < 64; ++s) {
    if (std::ranges::find(furthest, s) != furthest.end()) continue;
    EXPECT_LE(distance(s), distance(furthest.back())) << s;
  }
  EXPECT_TRUE(FurthestFromLenders({}, {}, 4).empty());
}

}  // namespace
}  // namespace penumbra::testing
