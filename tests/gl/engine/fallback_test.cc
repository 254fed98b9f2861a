// What becomes of specs that take GL while its worker is left alone.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <tuple>

#include "render/engine/compute_once.h"
#include "render/engine/local_engine.h"
#include "render/gl/lazy_worker.h"
#include "render/scene/field_error.h"
#include "tests/gl/engine/gl_specs.h"
#include "tests/support/test_device.h"

namespace penumbra::testing {
namespace {

using ::testing::HasSubstr;

constexpr double kMinuteMs = 60'000;

class GlFallbackTest : public ::testing::Test {
 protected:
  GlFallbackTest() : engine_({.gl_worker = [this] { return worker_.Get(); }}) {
    EXPECT_TRUE(engine_.CreateScene("s").ok());
    EXPECT_TRUE(engine_.Commit("s", BallOverFloor(40)).ok());
  }

  // That the next `count` checks of the worker's, one after each job, find the context lost.
  void Lose(int count, gl::Fault fault = gl::Fault::kLost) {
    fault_ = fault;
    left_ = count;
  }
  absl::StatusOr<std::shared_ptr<const Artifact>> Compute(const ArtifactSpec& spec) {
    return ComputeOnce(engine_, "s", spec);
  }
  const gl::WorkerHealth& health() { return worker_.Get().value()->health(); }

  std::atomic<int> left_ = 0;
  std::atomic<gl::Fault> fault_ = gl::Fault::kLost;
  std::atomic<double> now_ms_ = 0;
  gl::LazyWorker worker_{{.context = {.device = TestDevice(),
                                      .now_ms = [this] { return now_ms_.load(); },
                                      .inject_fault =
                                          [this](std::string_view what) {
                                            if (what != "gl::Worker" || left_ == 0) {
                                              return gl::Fault::kNone;
                                            }
                                            --left_;
                                            return fault_.load();
                                          }}}};
  LocalEngine engine_;
};

TEST_F(GlFallbackTest, AJobThatFailsTwiceAloneGetsTheErrorAndOthersGoOn) {
  const std::vector<GlSpec> specs = GlSpecs(48, 20);
  for (const auto& [fault, code, reason] :
       {std::tuple(gl::Fault::kLost, absl::StatusCode::kUnavailable, "GL_CONTEXT_LOST"),
        std::tuple(gl::Fault::kError, absl::StatusCode::kInternal, "GL_ERROR"),
        std::tuple(gl::Fault::kOutOfMemory, absl::StatusCode::kResourceExhausted,
                   "GL_OUT_OF_MEMORY")}) {
    Lose(2, fault);
    const auto failed = Compute(specs[0].spec);
    EXPECT_EQ(failed.status().code(), code) << failed.status();
    EXPECT_EQ(ErrorReason(failed.status()), reason);
    for (const GlSpec& spec : specs) EXPECT_TRUE(Compute(spec.spec).ok()) << spec.name;
    EXPECT_FALSE(health().is_degraded());
    now_ms_ = now_ms_ + 11 * kMinuteMs;
  }
}

TEST_F(GlFallbackTest, AfterThreeTheCpuComputesAllAndAfterTenMinutesGlAgain) {
  const std::vector<GlSpec> specs = GlSpecs(48, 20);
  std::vector<std::string> by_gl;
  for (const GlSpec& spec : specs) {
    const auto artifact = Compute(spec.spec);
    ASSERT_TRUE(artifact.ok()) << artifact.status();
    EXPECT_FALSE((*artifact)->header.parameters.contains("without_gl"));
    by_gl.push_back(BitsOf(**artifact));
  }
  Lose(1);
  EXPECT_TRUE(Compute(specs[0].spec).ok());
  Lose(2);  // the third on the whole, with which this job goes to the CPU
  const auto third = Compute(specs[0].spec);
  ASSERT_TRUE(third.ok()) << third.status();
  EXPECT_TRUE(health().is_degraded());
  LocalEngine without_gl;
  ASSERT_TRUE(without_gl.CreateScene("s").ok());
  ASSERT_TRUE(without_gl.Commit("s", BallOverFloor(40)).ok());
  for (size_t i = 0; i < specs.size(); ++i) {
    const auto artifact = Compute(specs[i].spec);
    ASSERT_TRUE(artifact.ok()) << specs[i].name << ": " << artifact.status();
    EXPECT_EQ((*artifact)->header.parameters.at("without_gl"), "the GL context was lost");
    const bool is_in_steps = SpecKey(specs[i].spec) == SpecKey(specs[i].by_cpu);
    const auto by_cpu =
        is_in_steps ? by_gl[i] : BitsOf(**ComputeOnce(without_gl, "s", specs[i].by_cpu));
    EXPECT_TRUE(BitsOf(**artifact) == by_cpu) << specs[i].name;
  }
  now_ms_ = 10 * kMinuteMs;
  for (size_t i = 0; i < specs.size(); ++i) {
    const auto artifact = Compute(specs[i].spec);
    ASSERT_TRUE(artifact.ok()) << artifact.status();
    EXPECT_FALSE((*artifact)->header.parameters.contains("without_gl")) << specs[i].name;
    EXPECT_TRUE(BitsOf(**artifact) == by_gl[i]) << specs[i].name;
  }
  EXPECT_FALSE(health().is_degraded());
}

TEST_F(GlFallbackTest, MoreGpuMemoryThanThereMayBeIsRefusedByName) {
  gl::LazyWorker small({.context = {.device = TestDevice(), .max_memory_bytes = 4096}});
  LocalEngine engine({.gl_worker = [&] { return small.Get(); }});
  ASSERT_TRUE(engine.CreateScene("s").ok());
  ASSERT_TRUE(engine.Commit("s", BallOverFloor(40)).ok());
  for (const GlSpec& spec : GlSpecs(48, 20)) {
    const absl::Status status = ComputeOnce(engine, "s", spec.spec).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted) << spec.name << ": " << status;
    EXPECT_THAT(ErrorReason(status), ::testing::AnyOf("QUOTA_GPU_BYTES", "GL_MEMORY"));
    EXPECT_THAT(std::string(status.message()), HasSubstr("bytes"));
  }
  EXPECT_EQ(small.Get().value()->rebuild_count(), 0);
}

}  // namespace
}  // namespace penumbra::testing
