// Contexts that are lost under the jobs of a whole engine: nobody notices.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "render/engine/local_engine.h"
#include "render/gl/lazy_worker.h"
#include "tests/gl/engine/gl_specs.h"
#include "tests/support/random_scene.h"
#include "tests/support/test_device.h"
#include "tests/unit/engine/scripted_technique.h"

namespace penumbra::testing {
namespace {

constexpr double kMinuteMs = 60'000;
constexpr int kScenes = 3, kEdits = 7;

// Loses `most` contexts, at any check of any job but the first of a context: the worker runs a job
// again as the first of the new one, and no job is to lose two.
class Losses {
 public:
  explicit Losses(int most) : most_(most) {}

  gl::Fault At(std::string_view what) {
    if (what == "gl::Context") jobs_done_ = 0;
    const bool is_due = jobs_done_ > 0 && dice_.Below(12) == 0;
    if (what == "gl::Worker") ++jobs_done_;  // asked at a job's end, which is a check of it too
    if (!is_due || count_ == most_) return gl::Fault::kNone;
    ++count_;
    jobs_done_ = 0;  // it is lost once
    return gl::Fault::kLost;
  }

  int count() const { return count_; }

 private:
  const int most_;
  int jobs_done_ = 0;  // of this context
  Dice dice_{1};
  std::atomic<int> count_ = 0;
};

// What all subscriptions see of a scene that is edited: "scene 2 shadow_width @5" → bits.
std::map<std::string, std::string> FinalBits(gl::LazyWorker& worker, int runners) {
  LocalEngine engine({.runner_threads = runners, .gl_worker = [&] { return worker.Get(); }});
  std::map<std::string, UpdateLog> logs;
  std::vector<std::unique_ptr<Subscription>> subscriptions;
  const std::vector<GlSpec> specs = GlSpecs(/*resolution=*/48, /*samples=*/70);
  for (int s = 0; s < kScenes; ++s) {
    const std::string id = absl::StrCat("scene", s);
    EXPECT_TRUE(engine.CreateScene(id).ok());
    EXPECT_TRUE(engine.Commit(id, BallOverFloor(30 + s)).ok());
    for (const GlSpec& spec : specs) {
      auto made = engine.Subscribe(id, spec.spec, logs[id + " " + spec.name].Callback());
      EXPECT_TRUE(made.ok()) << made.status();
      subscriptions.push_back(*std::move(made));
    }
  }
  std::map<std::string, std::string> bits;
  for (int edit = 0; edit < kEdits; ++edit) {
    for (int s = 0; s < kScenes; ++s) {
      const auto revision = engine.Commit(absl::StrCat("scene", s),
                                          BallAt(0.1f * static_cast<float>(edit + s) - 0.3f));
      EXPECT_TRUE(revision.ok()) << revision.status();
    }
    for (auto& [name, log] : logs) {
      const auto updates = log.AwaitFinalAt(static_cast<Revision>(edit + 2));
      bits[absl::StrCat(name, " @", edit + 2)] = BitsOf(*updates.back().artifact);
    }
  }
  for (auto& [name, log] : logs) {
    for (const ArtifactUpdate& update : log.all()) EXPECT_TRUE(update.status.ok()) << update.status;
  }
  EXPECT_EQ(engine.statistics().jobs_failed, 0u);
  return bits;
}

TEST(GlLossesTest, TwentyUnderConcurrentJobsChangeNoBit) {
  gl::LazyWorker undisturbed({.context = {.device = TestDevice()}});
  const auto expected = FinalBits(undisturbed, 1);
  Losses losses(20);
  gl::LazyWorker lossy(
      {.context = {.device = TestDevice(),
                   // So slow that no three of them fall into ten minutes.
                   .now_ms = [&] { return 5 * kMinuteMs * losses.count(); },
                   .inject_fault = [&](std::string_view what) { return losses.At(what); }}});
  const auto found = FinalBits(lossy, 4);
  EXPECT_EQ(losses.count(), 20);
  EXPECT_EQ(lossy.Get().value()->rebuild_count(), 20);
  EXPECT_FALSE(lossy.Get().value()->health().is_degraded());
  ASSERT_EQ(found.size(), expected.size());
  for (const auto& [name, bits] : expected) {
    EXPECT_FALSE(bits.empty()) << name;
    EXPECT_TRUE(found.at(name) == bits) << name;
  }
}

}  // namespace
}  // namespace penumbra::testing
