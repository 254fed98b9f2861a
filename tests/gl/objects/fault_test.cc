// What a worker does about faults, which tests inject: a software device has none of its own.
#include "render/gl/fault.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <vector>

#include "render/gl/buffer.h"
#include "render/gl/program.h"
#include "render/gl/worker.h"
#include "tests/support/test_device.h"

namespace penumbra::gl {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kMinuteMs = 60'000;

class FaultTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto worker = Worker::Create(
        {.context = {
             .device = TestDevice(),
             .max_memory_bytes = 1000,
             .now_ms = [this] { return now_ms_.load(); },
             .inject_fault =
                 [this](std::string_view what) { return what == at_ ? Next() : Fault::kNone; }},
         .on_health_change = [this](bool is_degraded) { changes_.push_back(is_degraded); }});
    ASSERT_TRUE(worker.ok()) << worker.status();
    worker_ = *std::move(worker);
  }

  // That the next checks of "the job" come upon these.
  void Inject(std::vector<Fault> faults, std::string at = "the job") {
    faults_ = std::move(faults);
    at_ = std::move(at);
  }
  Fault Next() {
    if (faults_.empty()) return Fault::kNone;
    const Fault fault = faults_.front();
    faults_.erase(faults_.begin());
    return fault;
  }
  // How a job went that does nothing but to look whether all is well.
  absl::Status RunCheck() {
    return worker_->Run([this](Context& context) {
      ++runs_;
      return context.Check("the job");
    });
  }

  std::atomic<double> now_ms_ = 0;
  // The worker's thread alone uses them while a job runs.
  std::vector<Fault> faults_;
  std::string at_;
  std::vector<bool> changes_;
  int runs_ = 0;
  std::unique_ptr<Worker> worker_;
};

TEST_F(FaultTest, EachIsMendedOnce) {
  for (const Fault fault : {Fault::kLost, Fault::kError, Fault::kOutOfMemory}) {
    runs_ = 0;
    Inject({fault});
    EXPECT_TRUE(RunCheck().ok()) << ReasonOf(fault);
    EXPECT_EQ(runs_, 2) << ReasonOf(fault);
  }
  EXPECT_EQ(worker_->rebuild_count(), 3);
}

TEST_F(FaultTest, TwiceIsTheJobsErrorAndTheNextOneRuns) {
  struct Case {
    Fault fault;
    absl::StatusCode code;
    const char* reason;
  };
  for (const auto& [fault, code, reason] :
       {Case{Fault::kLost, absl::StatusCode::kUnavailable, "GL_CONTEXT_LOST"},
        Case{Fault::kError, absl::StatusCode::kInternal, "GL_ERROR"},
        Case{Fault::kOutOfMemory, absl::StatusCode::kResourceExhausted, "GL_OUT_OF_MEMORY"}}) {
    Inject({fault, fault});
    const absl::Status status = RunCheck();
    EXPECT_EQ(status.code(), code) << status;
    EXPECT_EQ(FaultOf(status), fault) << status;
    EXPECT_EQ(ReasonOf(fault), reason);
    EXPECT_TRUE(RunCheck().ok()) << reason;
    now_ms_ = now_ms_ + 11 * kMinuteMs;
  }
}

// Names are numbers, and the new context gives out the same ones.
TEST_F(FaultTest, ObjectsOfALostContextLeaveThoseOfTheNewOneAlone) {
  const std::array<uint32_t, 1> written = {0x12345678};
  std::vector<Buffer> of_the_old, of_the_new;
  std::vector<uint32_t> names;
  Inject({Fault::kLost});
  const absl::Status status = worker_->Run([&](Context& context) -> absl::Status {
    auto& buffers = names.empty() ? of_the_old : of_the_new;
    auto buffer = Buffer::Create(context, std::as_bytes(std::span(written)));
    if (!buffer.ok()) return buffer.status();
    names.push_back(buffer->name());
    buffers.push_back(*std::move(buffer));
    if (absl::Status checked = context.Check("the job"); !checked.ok()) return checked;
    of_the_old.clear();
    std::array<uint32_t, 1> read = {};
    const absl::Status was_read =
        of_the_new.front().Read(context, 0, std::as_writable_bytes(std::span(read)));
    EXPECT_EQ(read, written);
    of_the_new.clear();
    return was_read;
  });
  EXPECT_TRUE(status.ok()) << status;
  ASSERT_EQ(names.size(), 2u);
  EXPECT_EQ(names[0], names[1]) << "or the test shows nothing";
}

TEST_F(FaultTest, AShaderThatDoesNotCompileIsTriedAgain) {
  int runs = 0;
  const absl::Status status = worker_->Run([&](Context& context) {
    ++runs;
    return Program::Create(context, {.compute = "nonsense"}).status();
  });
  EXPECT_EQ(FaultOf(status), Fault::kError) << status;
  EXPECT_EQ(status.code(), absl::StatusCode::kInternal);
  EXPECT_EQ(runs, 2);
}

TEST_F(FaultTest, WhatIsKeptGivesWayToAJobThatNeedsItsMemory) {
  static constexpr char kOwner = 0;
  std::vector<bool> was_kept;
  const auto run = [&](size_t bytes) {
    return worker_->Run([&, bytes](Context& context) {
      was_kept.push_back(context.Kept(&kOwner) != nullptr);
      auto buffer = Buffer::Create(context, bytes);
      if (!buffer.ok()) return buffer.status();
      context.Kept(&kOwner) = std::make_shared<Buffer>(*std::move(buffer));
      return absl::OkStatus();
    });
  };
  EXPECT_TRUE(run(600).ok());
  EXPECT_TRUE(run(700).ok());
  EXPECT_THAT(was_kept, ElementsAre(false, true, false));
  EXPECT_EQ(worker_->rebuild_count(), 0);
  const absl::Status refused = run(1001);
  EXPECT_EQ(refused.code(), absl::StatusCode::kResourceExhausted) << refused;
  EXPECT_EQ(ReasonOf(FaultOf(refused)), "QUOTA_GPU_BYTES");
  EXPECT_THAT(std::string(refused.message()), HasSubstr("found 1001 bytes"));
  EXPECT_THAT(std::string(refused.message()), HasSubstr("need at most 1000"));
  EXPECT_FALSE(worker_->health().is_degraded());
}

TEST_F(FaultTest, ThreeFailuresInTenMinutesAndItIsLeftAloneUntilOneIsLongAgo) {
  const WorkerHealth& health = worker_->health();
  for (int failure = 0; failure < 3; ++failure) {
    EXPECT_TRUE(health.TakesJobs()) << failure;
    EXPECT_EQ(health.reason(), "");
    Inject({Fault::kLost});
    EXPECT_TRUE(RunCheck().ok());
    now_ms_ = now_ms_ + 4 * kMinuteMs;  // at 0, 4 and 8 minutes
  }
  EXPECT_TRUE(health.is_degraded()) << "12 minutes after the first, but nothing went well since";
  EXPECT_EQ(health.reason(), "the GL context was lost");
  now_ms_ = 9 * kMinuteMs;
  EXPECT_FALSE(health.TakesJobs());
  now_ms_ = 10 * kMinuteMs;
  EXPECT_TRUE(health.TakesJobs());
  EXPECT_TRUE(health.is_degraded());
  EXPECT_TRUE(RunCheck().ok());
  EXPECT_FALSE(health.is_degraded());
  EXPECT_THAT(changes_, ElementsAre(true, false));
}

TEST_F(FaultTest, FailuresFarApartAndLackOfMemoryAreNoReason) {
  for (int failure = 0; failure < 10; ++failure) {
    Inject({Fault::kLost});
    EXPECT_TRUE(RunCheck().ok());
    now_ms_ = now_ms_ + 5 * kMinuteMs;
    Inject({Fault::kOutOfMemory, Fault::kOutOfMemory});
    EXPECT_FALSE(RunCheck().ok());
  }
  EXPECT_FALSE(worker_->health().is_degraded());
  EXPECT_THAT(changes_, ElementsAre());
}

TEST_F(FaultTest, AContextThatCannotBeMadeNowIsMadeForALaterJob) {
  Inject({Fault::kLost});
  const absl::Status lost = worker_->Run([this](Context& context) {
    const absl::Status status = context.Check("the job");
    Inject({Fault::kLost, Fault::kLost, Fault::kLost}, "gl::Context");
    return status;
  });
  EXPECT_EQ(FaultOf(lost), Fault::kLost) << lost;
  EXPECT_THAT(std::string(lost.message()), HasSubstr("cannot be made again"));
  EXPECT_TRUE(RunCheck().ok());
}

}  // namespace
}  // namespace penumbra::gl
