// A thread that owns a GL context, and a queue of work for it.
//
//   auto worker = gl::Worker::Create({.context = {.device = options.egl_device}});
//   if (!worker.ok()) return worker.status();
//   absl::Status done = (*worker)->Run([&](gl::Context& context) { return Draw(context); });
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "render/gl/context.h"
#include "render/gl/worker_health.h"

namespace penumbra::gl {

struct WorkerOptions {
  ContextOptions context;
  size_t max_queued = 64;  // jobs waiting; past that Submit refuses
  // Told on the worker's thread when its health changes.
  std::function<void(bool is_degraded)> on_health_change = nullptr;
};

// Jobs run one at a time, in order, with the context current. After a job that a fault befell the
// worker mends what it can and runs the job once more; so a job keeps nothing on the GPU but what
// it can make again (see Context::serial and Kept). What it does:
//
//   lost, error       a new context; counts as a failure of the worker's health
//   out of memory     a new context, with which all that was kept goes
//   over the budget   all that was kept goes
//
// Any thread may submit. Destroying runs what is queued, then ends.
class Worker {
 public:
  using Job = std::function<void(Context&)>;

  // Errors  those of Context::Create
  static absl::StatusOr<std::unique_ptr<Worker>> Create(const WorkerOptions& options = {});
  ~Worker();
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  // Queues `job`. Errors  kResourceExhausted: the queue is full
  absl::Status Submit(Job job);

  // Queues `job`, waits for it and returns what it returned. Not from a job of the same worker.
  // Errors  those of Submit; that of the fault that befell the job twice (FaultOf), kUnavailable if
  //         the context could not be made again
  absl::Status Run(std::function<absl::Status(Context&)> job);

  // Of the context in use; a copy, for it changes when the context is made again.
  ContextInfo info() const;
  // How often the context was made again.
  int rebuild_count() const;
  // Who has another way to do a job asks it first: the worker refuses nothing.
  const WorkerHealth& health() const { return health_; }

 private:
  // A job, and who to tell how it went.
  struct Entry {
    Job job;
    std::function<void(absl::Status)> finish;  // may be null
  };

  explicit Worker(const WorkerOptions& options)
      : options_(options),
        health_({.now_ms = options.context.now_ms, .on_change = options.on_health_change}) {}
  void Loop();
  absl::Status MakeContext();
  absl::Status RunOnce(Entry& entry);
  void Mend(Fault fault);
  void RunEntry(Entry& entry);
  absl::Status Push(Entry entry);

  const WorkerOptions options_;
  WorkerHealth health_;
  std::unique_ptr<Context> context_;  // the thread's own; null while it cannot be made

  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Entry> queue_;  // guarded by mutex_, as all below
  bool is_stopping_ = false;
  bool has_started_ = false;
  absl::Status context_status_;
  ContextInfo info_;
  int rebuild_count_ = 0;

  std::thread thread_;
};

}  // namespace penumbra::gl
