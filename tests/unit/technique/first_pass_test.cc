#include "render/technique/first_pass.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "render/scene/field_error.h"
#include "render/technique/technique.h"
#include "tests/unit/technique/soft_texture_scenes.h"

namespace penumbra::testing {
namespace {

TEST(FirstPassPace, KnowsNothingAtFirst) { EXPECT_EQ(FirstPassPace().Samples(20, 8), 8u); }

// Whatever a pass costs besides its samples, a dozen steps find how many fit, to a tenth.
TEST(FirstPassPace, FindsHowManySamplesFit) {
  for (const double fixed_ms : {0.0, 5.0, 12.0}) {
    for (const double sample_ms : {0.01, 0.1, 1.0}) {
      FirstPassPace pace;
      uint32_t samples = 8;
      for (int step = 0; step < 12; ++step) {
        pace.Learn(samples, fixed_ms + samples * sample_ms);
        samples = pace.Samples(20, 8);
      }
      const double ms = fixed_ms + samples * sample_ms;
      EXPECT_GT(ms, 18 - sample_ms) << fixed_ms;
      EXPECT_LT(ms, 20 + sample_ms) << fixed_ms;
    }
  }
}

TEST(FirstPassPace, CountsOneSampleHoweverLongItTakes) {
  FirstPassPace pace;
  pace.Learn(8, 1e9);
  EXPECT_EQ(pace.Samples(20, 8), 1u);
}

class TimeBudgetTest : public ::testing::Test {
 protected:
  // How many samples each artifact of a computation counts, by a clock on which a sample's first
  // look takes `look_ms`.
  std::vector<uint32_t> PassesWith(float budget_ms, double look_ms) {
    spec_.time_budget_ms = budget_ms;
    double now = 0;
    std::vector<uint32_t> passes;
    const ComputeContext context{.arena = arena_,
                                 .progress =
                                     [&](const Artifact& pass) {
                                       passes.push_back(TextureOf(pass).visibility.sample_count);
                                     },
                                 .now_ms = [&] { return now += look_ms; },
                                 .memory = &memory_};
    const auto last = TechniqueFor(spec_.params).Compute(*scene_, spec_, context);
    passes.push_back(TextureOf(*last).visibility.sample_count);
    return passes;
  }

  tbb::task_arena arena_{1};
  MemoryBudget budget_{0};
  TechniqueMemory memory_{budget_};
  std::shared_ptr<const Scene> scene_ = [] {
    SceneDelta delta = RandomBoxes(5, 7);
    delta.upsert_lights = {Ceiling()};
    delta.upsert_receivers = {Floor(40, 30)};
    return SceneOf(delta);
  }();
  ArtifactSpec spec_{
      .params = SoftTextureParams{.samples = 500}, .light_id = "light", .receiver_id = "floor"};
};

TEST_F(TimeBudgetTest, WithoutOneTheFirstPassCountsEight) {
  for (int round = 0; round < 2; ++round) {
    EXPECT_EQ(PassesWith(0, 1), (std::vector<uint32_t>{8, 64, 500}));
  }
}

TEST_F(TimeBudgetTest, TheFirstPassTakesAsManyAsFit) {
  EXPECT_EQ(PassesWith(100, 1)[0], 8u);   // nothing is known yet
  EXPECT_EQ(PassesWith(100, 1)[0], 32u);  // there was time for more, but not all at once
  const auto passes = PassesWith(100, 1e6);
  EXPECT_GT(passes[0], 32u);
  EXPECT_EQ(PassesWith(100, 1)[0], 1u);  // the last one took far too long
  EXPECT_EQ(PassesWith(100, 1).back(), 500u) << "it is refined to the end whatever the budget";
}

TEST_F(TimeBudgetTest, OneThatIsNoTimeIsRefused) {
  for (const float bad :
       {-1.0f, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    spec_.time_budget_ms = bad;
    const absl::Status status = TechniqueFor(spec_.params).Check(*scene_, spec_);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_EQ(ErrorFieldPath(status), "time_budget_ms");
  }
}

}  // namespace
}  // namespace penumbra::testing
