// Which thread takes which task, and how many run at a time.
#include "render/engine/worker_pool.h"

#include <atomic>
#include <latch>
#include <memory>
#include <thread>
#include <utility>

#include "gtest/gtest.h"

namespace penumbra {
namespace {

TEST(WorkerPool, ALaneOfBlockedTasksHoldsUpNoOther) {
  WorkerPool pool({2, 1});
  std::latch entered(2), leave(1), ran(1);
  for (int i = 0; i < 5; ++i) {
    pool.lane(0).Post([&, i] {
      if (i < 2) entered.count_down();
      leave.wait();
    });
  }
  entered.wait();
  pool.lane(1).Post([&] { ran.count_down(); });
  ran.wait();
  leave.count_down();
}

TEST(WorkerPool, NoMoreTasksOfALaneRunAtATimeThanItsBound) {
  WorkerPool pool({2, 3});
  std::atomic<int> running = 0, most = 0;
  std::latch done(200);
  for (int i = 0; i < 200; ++i) {
    pool.lane(0).Post([&] {
      const int now = ++running;
      int seen = most;
      while (seen < now && !most.compare_exchange_weak(seen, now)) {
      }
      std::this_thread::yield();
      --running;
      done.count_down();
    });
  }
  done.wait();
  EXPECT_LE(most, 2);
}

TEST(WorkerPool, ThePostersThreadTakesWhatIsPostedNext) {
  WorkerPool pool({2, 1});  // room for a delivery that has counted down and not yet ended
  for (int round = 0; round < 100; ++round) {
    std::thread::id job, delivery;
    std::latch done(1);
    pool.lane(1).Post([&] {
      job = std::this_thread::get_id();
      pool.lane(0).PostNext([&] {
        delivery = std::this_thread::get_id();
        done.count_down();
      });
    });
    done.wait();
    ASSERT_EQ(job, delivery) << round;
  }
}

TEST(WorkerPool, OfTwoPostedNextAnotherThreadTakesTheSecond) {
  WorkerPool pool({2, 1});
  std::latch both(2);
  pool.lane(1).Post([&] {
    // Each waits for the other, so one thread alone would never end.
    for (int i = 0; i < 2; ++i) pool.lane(0).PostNext([&] { both.arrive_and_wait(); });
  });
  both.wait();
}

TEST(WorkerPool, WhatIsPostedNextWaitsForRoomInItsLane) {
  WorkerPool pool({1, 1});
  std::latch entered(1), leave(1), posted(1), done(1);
  pool.lane(0).Post([&] {
    entered.count_down();
    leave.wait();
  });
  entered.wait();
  std::atomic<bool> ran = false;
  pool.lane(1).Post([&] {
    pool.lane(0).PostNext([&] {
      ran = true;
      done.count_down();
    });
  });
  pool.lane(1).Post([&] { posted.count_down(); });  // begins after the one before has ended
  posted.wait();
  EXPECT_FALSE(ran);
  leave.count_down();
  done.wait();
}

TEST(WorkerPool, StoppingDropsWhatHasNotBegun) {
  std::latch entered(1), leave(1);
  std::atomic<int> ran = 0;
  WorkerPool pool({1});
  pool.lane(0).Post([&] {
    ++ran;
    entered.count_down();
    leave.wait();
  });
  // The task that runs ends once the one that waits is dropped.
  std::shared_ptr<void> dropped(nullptr, [&](void*) { leave.count_down(); });
  pool.lane(0).Post([&, held = std::move(dropped)] { ++ran; });
  entered.wait();
  pool.Stop();
  pool.lane(0).Post([&] { ++ran; });
  EXPECT_EQ(ran, 1);
}

}  // namespace
}  // namespace penumbra
