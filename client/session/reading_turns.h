// A few threads that take turns to read a stream. Whoever has read something that takes long to
// deal with hands the reading to the next one and deals with it itself: the work starts at once, on
// a warm thread, and the stream is never left alone.
//
//   ReadingTurns turns([&] { …read, and turns.Post(job) where a callback is due…; return more; });
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace penumbra {

class ReadingTurns {
 public:
  // One reads; that many more may be in jobs at a time. More jobs wait.
  static constexpr int kMaxJobs = 2;

  // `read_one` waits for one message and deals with it; false says that none will follow. It is
  // called by one thread at a time.
  explicit ReadingTurns(std::function<bool()> read_one);
  // Waits for the end of the stream and for all jobs.
  ~ReadingTurns();
  ReadingTurns(const ReadingTurns&) = delete;
  ReadingTurns& operator=(const ReadingTurns&) = delete;

  void Start();
  // Once all is read and all jobs have run. Not from inside a job.
  void Join();

  // From inside read_one: `job` runs when it returns.
  void Post(std::function<void()> job);
  // Likewise, but another thread runs it at once, if one is free, however long read_one takes.
  void PostAtOnce(std::function<void()> job);

 private:
  void Run();
  void Read(std::unique_lock<std::mutex>& lock);
  bool MayRunJob() const { return !jobs_.empty() && (has_ended_ || running_jobs_ < kMaxJobs); }

  const std::function<bool()> read_one_;
  std::mutex mutex_;
  std::condition_variable turn_;
  bool has_reader_ = false;
  bool has_ended_ = false;
  int running_jobs_ = 0;
  std::deque<std::function<void()>> jobs_;
  std::vector<std::thread> threads_;
};

}  // namespace penumbra
