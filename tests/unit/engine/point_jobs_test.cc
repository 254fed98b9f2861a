// Jobs for points may take minutes, and nothing else waits for them.
#include <chrono>
#include <future>
#include <memory>
#include <stop_token>
#include <thread>
#include <vector>

#include "gtest/gtest.h"
#include "render/engine/local_engine.h"
#include "render/math/parallel_for.h"
#include "tests/unit/engine/scripted_technique.h"

namespace penumbra::testing {
namespace {

ArtifactSpec Picture(uint64_t seed) {
  ArtifactSpec spec{CoherentRaytraceParams{.seed = seed}, "lamp"};
  spec.points = PicturePixels{.width = 8, .height = 8};
  return spec;
}

// For points: on all threads that it is given, until it is stopped.
absl::StatusOr<Artifact> EndlessForPoints(const Scene& scene, const ArtifactSpec& spec,
                                          const ComputeContext& context) {
  if (!spec.points) {
    RunIn(context.arena, [] {});
    return LabelledArtifact(scene, 0, true);
  }
  context.progress(LabelledArtifact(scene, 0, false));
  RunIn(context.arena, [&] {
    ParallelFor(context.arena.max_concurrency(), [&](int) {
      while (!context.stop.stop_requested()) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
    });
  });
  return absl::CancelledError("stopped");
}

TEST(PointJobsTest, MoreThanThereAreRunnersHoldUpNoOtherArtifact) {
  const FunctionTechnique technique(EndlessForPoints);
  LocalEngineOptions options = OptionsFor(technique);
  options.cpu_threads = 2;
  LocalEngine engine(options);
  ASSERT_TRUE(engine.CreateScene("s").ok());
  ASSERT_TRUE(engine.Commit("s", LampAndFloor()).ok());
  // Somebody looks, and what may show anywhere in his picture is wanted most.
  ASSERT_TRUE(engine.ReportView("s", "me", View{}).ok());

  UpdateLog pictures;
  std::vector<std::unique_ptr<Subscription>> subscriptions;
  for (int i = 0; i <= options.runner_threads; ++i) {
    subscriptions.push_back(engine.Subscribe("s", Picture(i), pictures.Callback()).value());
  }
  pictures.AwaitCount(1);
  std::promise<void> came;
  subscriptions.push_back(
      engine.Subscribe("s", LampOnFloor(), [&](const ArtifactUpdate&) { came.set_value(); })
          .value());
  EXPECT_EQ(came.get_future().wait_for(std::chrono::seconds(20)), std::future_status::ready);

  // The next one begins when nobody wants the first any more.
  subscriptions.erase(subscriptions.begin());
  pictures.AwaitCount(2);
}

}  // namespace
}  // namespace penumbra::testing
