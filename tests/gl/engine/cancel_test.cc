// How soon a job that takes GL is over once it is stopped, wherever it is: within 100 ms, on a
// software device too. Measured in the process's own CPU time, which is no less than the wall's
// where nothing else runs, and does not grow where something does.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <iostream>
#include <thread>

#include "render/engine/gl_job.h"
#include "render/gl/framebuffer.h"
#include "tests/gl/engine/gl_specs.h"
#include "tests/support/test_device.h"

namespace penumbra::testing {
namespace {

using Clock = std::chrono::steady_clock;

double NowMs() {
  return std::chrono::duration<double, std::milli>(Clock::now().time_since_epoch()).count();
}

double CpuMs() { return 1000.0 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

class GlCancelTest : public ::testing::TestWithParam<size_t> {
 protected:
  // From the stop until the worker has done another job; −1: it had ended before.
  double StopAfter(const Scene& scene, const ArtifactSpec& spec, double ms) {
    std::stop_source source;
    absl::Status status;
    std::jthread job([&] {
      const ComputeContext context{.arena = arena_,
                                   .stop = source.get_token(),
                                   .progress = [](Artifact) {},
                                   .now_ms = NowMs};
      status = ComputeOnGl(TechniqueFor(spec.params), scene, spec, context, [&] {
                 return absl::StatusOr<gl::Worker*>(worker_.get());
               }).status();
    });
    std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(ms));
    const double stopped_ms = CpuMs();
    source.request_stop();
    job.join();
    // What the device was still asked for counts too.
    EXPECT_TRUE(worker_->Run([](gl::Context& context) { return Flush(context); }).ok());
    if (status.ok()) return -1;
    EXPECT_EQ(status.code(), absl::StatusCode::kCancelled) << status;
    return CpuMs() - stopped_ms;
  }

  static absl::Status Flush(gl::Context& context) {
    auto target = gl::Framebuffer::Create(context, {.width = 1, .height = 1, .has_depth = false});
    if (!target.ok()) return target.status();
    target->Clear(context, Vec4(0));
    return target->ReadPixels(context).status();
  }

  tbb::task_arena arena_{2};
  std::unique_ptr<gl::Worker> worker_ =
      gl::Worker::Create({.context = {.device = TestDevice(), .now_ms = NowMs}}).value();
};

TEST_P(GlCancelTest, IsHeardOfWithin100Ms) {
  // Layers of more pixels are refused.
  const uint32_t resolution = GetParam() == 1 ? 2048 : 4096;
  const GlSpec spec = GlSpecs(resolution, /*samples=*/256)[GetParam()];
  const auto scene = Scene::Empty("s")->Apply(BallOverFloor(2048, 600)).value();
  std::vector<double> heard_ms;
  for (const double ms : {30, 80, 150, 250, 400, 600, 900, 1300, 2000}) {
    const double took_ms = StopAfter(*scene, spec.spec, ms);
    std::cout << spec.name << ": stopped after " << ms << " ms, heard of after " << took_ms
              << " ms\n";
    if (took_ms >= 0) heard_ms.push_back(took_ms);
  }
  ASSERT_GE(heard_ms.size(), 3u) << "the job is too short to be stopped";
  std::ranges::sort(heard_ms);
  EXPECT_LE(heard_ms[heard_ms.size() / 2], 100);
}

INSTANTIATE_TEST_SUITE_P(Specs, GlCancelTest, ::testing::Range(size_t{0}, size_t{5}));

}  // namespace
}  // namespace penumbra::testing
