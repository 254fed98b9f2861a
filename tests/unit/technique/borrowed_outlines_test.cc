// Outlines borrowed from neighbouring light samples: nearly right, by as much as is reported.
#include "render/technique/soft_texture/borrowed_outlines.h"

#include <gtest/gtest.h>

#include <set>

#include "render/scene/field_error.h"
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

TEST(BorrowedOutlines, AreRefusedByMethodsThatHaveNone) {
  const auto scene = TorusScene();
  for (const auto method :
       {VisibilityMethod::kCoverage, VisibilityMethod::kEdgeFlag, VisibilityMethod::kGl}) {
    const auto status = Compute(*scene, {.method = method, .silhouette_reuse = 8}).status();
    EXPECT_EQ(ErrorFieldPath(status), "soft_texture.silhouette_reuse") << status;
  }
  const SoftTextureParams exact{.method = VisibilityMethod::kCoverage, .silhouette_reuse = 1};
  EXPECT_TRUE(Compute(*scene, exact).ok());
}

TEST(BorrowedOutlines, OfAllLightsReportTheWorst) {
  AreaLight low = Ceiling(3.5f);
  low.id = "low";
  const auto scene = TorusScene()->Apply({.upsert_lights = {low}}).value();
  tbb::task_arena arena(2);
  const auto error = [&](const std::string& light) {
    const ArtifactSpec spec{SoftTextureParams{.samples = 64, .silhouette_reuse = 8}, light,
                            "floor"};
    return ReportedError(TechniqueFor(spec.params).Compute(*scene, spec, {.arena = arena}).value());
  };
  EXPECT_GT(error("low"), 0);
  EXPECT_EQ(error("*"), std::max(error("low"), error("light")));
}

// What is wrong where the receiver is not does not count.
TEST(BorrowedOutlines, AreLookedAtOnTheReceiverAlone) {
  CoverageMask mask(40, 2);
  SampleShadows a(40, 2, 1);
  const SampleShadows b(40, 2, 1);
  ShadowBitmap bitmap(40, 2);
  bitmap.Column(0)[0] = 0b110;
  bitmap.Column(1)[1] = 0b1;
  bitmap.Touch(0, 2, 0, 2);
  a.Store(0, 0, bitmap);
  EXPECT_EQ(LargestDifference(a, b, 1, 40, 2, nullptr), 3.0 / 80);
  EXPECT_EQ(LargestDifference(a, b, 1, 40, 2, &mask), 0);
  mask.Set(1);
  mask.Set(7);
  EXPECT_EQ(LargestDifference(a, b, 1, 40, 2, &mask), 1.0 / 2);
  mask.Set(40 + 32);
  EXPECT_EQ(LargestDifference(a, b, 1, 40, 2, &mask), 2.0 / 3);
}

class BorrowedOutlinesOf : public ::testing::TestWithParam<std::tuple<VisibilityMethod, float>> {};

// By auto too, and where the lamp is on both sides of the floor.
INSTANTIATE_TEST_SUITE_P(All, BorrowedOutlinesOf,
                         ::testing::Combine(::testing::Values(VisibilityMethod::kSilhouette,
                                                              VisibilityMethod::kAuto),
                                            ::testing::Values(4.0f, 0.0f)));

TEST_P(BorrowedOutlinesOf, AreTheSameForAnyThreadsPassesAndEdits) {
  const auto [method, height] = GetParam();
  AreaLight lamp = Ceiling(height);
  std::get<RectangleLight>(lamp.shape).corner.y -= 0.25f;
  std::get<RectangleLight>(lamp.shape).edge_u.y = 0.5f;
  const auto scene = TorusScene()->Apply({.upsert_lights = {lamp}}).value();
  const SoftTextureParams params{.samples = 64, .method = method, .silhouette_reuse = 8};
  const auto anew = [&](const Scene& s, int threads) {
    return Compute(s, params, threads).value();
  };
  const Artifact one = anew(*scene, 1);
  EXPECT_EQ(CountsOf(anew(*scene, 4)), CountsOf(one));
  tbb::task_arena arena(2);
  const ArtifactSpec spec{params, "light", "floor"};
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
              CountsOf(anew(*edited, 2)))
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
  for (size_t s = 0; s < 64; ++s) {
    Aabb group;
    for (size_t t = 0; t < 64; ++t) {
      if (lenders[t].point == lenders[s].point) group.Add(samples[t].point);
    }
    const auto off = [&](Vec3 point) { return glm::length(point - group.center()); };
    for (size_t t = 0; t < 64; ++t) {
      if (lenders[t].point != lenders[s].point) continue;
      EXPECT_LE(off(lenders[s].point), off(samples[t].point) + 1e-6f) << s << " " << t;
    }
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
