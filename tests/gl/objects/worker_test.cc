#include "render/gl/worker.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <thread>
#include <vector>

#include "render/gl/buffer.h"
#include "tests/support/test_device.h"

namespace penumbra::gl {
namespace {

using ::testing::HasSubstr;

WorkerOptions Software(size_t max_queued = 64) {
  return {.context = {.device = TestDevice()}, .max_queued = max_queued};
}

TEST(WorkerTest, RunsJobsInOrderOnOneThreadOfItsOwn) {
  auto worker = Worker::Create(Software());
  ASSERT_TRUE(worker.ok()) << worker.status();
  std::vector<int> order;
  std::vector<std::thread::id> threads;
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE((*worker)
                    ->Submit([&, i](Context&) {
                      order.push_back(i);
                      threads.push_back(std::this_thread::get_id());
                    })
                    .ok());
  }
  ASSERT_TRUE((*worker)->Run([](Context&) { return absl::OkStatus(); }).ok());
  ASSERT_EQ(order.size(), 20u);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(order[i], i);
  for (const auto id : threads) EXPECT_EQ(id, threads.front());
  EXPECT_NE(threads.front(), std::this_thread::get_id());
}

TEST(WorkerTest, ReturnsWhatTheJobReturns) {
  auto worker = Worker::Create(Software());
  ASSERT_TRUE(worker.ok()) << worker.status();
  const absl::Status status =
      (*worker)->Run([](Context&) { return absl::DataLossError("the job's own"); });
  EXPECT_EQ(status, absl::DataLossError("the job's own"));
}

TEST(WorkerTest, AFullQueueRefuses) {
  std::promise<void> started, release;  // outlive the worker, whose job waits on them
  auto worker = Worker::Create(Software(/*max_queued=*/2));
  ASSERT_TRUE(worker.ok()) << worker.status();
  ASSERT_TRUE((*worker)
                  ->Submit([&](Context&) {
                    started.set_value();
                    release.get_future().wait();
                  })
                  .ok());
  started.get_future().wait();
  EXPECT_TRUE((*worker)->Submit([](Context&) {}).ok());
  EXPECT_TRUE((*worker)->Submit([](Context&) {}).ok());
  const absl::Status refused = (*worker)->Submit([](Context&) {});
  EXPECT_EQ(refused.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(refused.message()), HasSubstr("found 2 jobs waiting"));
  release.set_value();
}

TEST(WorkerTest, ALostContextIsMadeAgainAndTheJobRunsOnceMore) {
  auto worker = Worker::Create(Software());
  ASSERT_TRUE(worker.ok()) << worker.status();
  std::vector<uint64_t> serials;
  std::vector<Buffer> survivors;  // made in the context that goes
  const absl::Status status = (*worker)->Run([&](Context& context) {
    serials.push_back(context.serial());
    auto buffer = Buffer::Create(context, 64);
    if (!buffer.ok()) return buffer.status();
    if (serials.size() == 1) {
      survivors.push_back(*std::move(buffer));
      context.SimulateLoss();
    }
    return absl::OkStatus();
  });
  EXPECT_TRUE(status.ok()) << status;
  ASSERT_EQ(serials.size(), 2u);
  EXPECT_NE(serials[0], serials[1]);
  EXPECT_EQ((*worker)->rebuild_count(), 1);
  EXPECT_TRUE((*worker)->info().is_software);
}

TEST(WorkerTest, AJobThatLosesEveryContextFailsAndTheNextOneRuns) {
  auto worker = Worker::Create(Software());
  ASSERT_TRUE(worker.ok()) << worker.status();
  int runs = 0;
  const absl::Status status = (*worker)->Run([&](Context& context) {
    ++runs;
    context.SimulateLoss();
    return absl::OkStatus();
  });
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(status.message()), HasSubstr("lost twice"));
  EXPECT_EQ(runs, 2);
  EXPECT_TRUE((*worker)->Run([](Context& context) { return context.Check("next"); }).ok());
}

TEST(WorkerTest, DestroyingRunsWhatIsQueued) {
  std::atomic<int> runs = 0;
  {
    auto worker = Worker::Create(Software());
    ASSERT_TRUE(worker.ok()) << worker.status();
    for (int i = 0; i < 10; ++i) ASSERT_TRUE((*worker)->Submit([&](Context&) { ++runs; }).ok());
  }
  EXPECT_EQ(runs, 10);
}

TEST(WorkerTest, NoDeviceIsToldByCreate) {
  const auto worker = Worker::Create({.context = {.device = "voodoo2"}});
  EXPECT_EQ(worker.status().code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace penumbra::gl
