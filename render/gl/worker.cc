#include "render/gl/worker.h"

#include <future>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"

namespace penumbra::gl {

absl::StatusOr<std::unique_ptr<Worker>> Worker::Create(const WorkerOptions& options) {
  std::unique_ptr<Worker> worker(new Worker(options));
  worker->thread_ = std::thread([raw = worker.get()] { raw->Loop(); });
  std::unique_lock lock(worker->mutex_);
  worker->wake_.wait(lock, [&] { return worker->has_started_; });
  const absl::Status status = worker->context_status_;
  lock.unlock();
  if (!status.ok()) return status;
  return worker;
}

Worker::~Worker() {
  {
    const std::lock_guard lock(mutex_);
    is_stopping_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

absl::Status Worker::Push(Entry entry) {
  {
    const std::lock_guard lock(mutex_);
    if (!context_status_.ok()) return context_status_;
    if (queue_.size() >= options_.max_queued) {
      return absl::ResourceExhaustedError(
          absl::StrCat("GL worker: found ", queue_.size(), " jobs waiting, which is its limit"));
    }
    queue_.push_back(std::move(entry));
  }
  wake_.notify_all();
  return absl::OkStatus();
}

absl::Status Worker::Submit(Job job) { return Push({.job = std::move(job), .finish = nullptr}); }

absl::Status Worker::Run(std::function<absl::Status(Context&)> job) {
  // A job that runs a second time overwrites what the first run returned.
  std::optional<absl::Status> result;
  // Shared: the worker may still be inside set_value when the waiting thread goes on.
  const auto finished = std::make_shared<std::promise<absl::Status>>();
  auto done = finished->get_future();
  Entry entry;
  entry.job = [&](Context& context) { result = job(context); };
  entry.finish = [finished](absl::Status status) { finished->set_value(std::move(status)); };
  if (absl::Status status = Push(std::move(entry)); !status.ok()) return status;
  const absl::Status status = done.get();
  return status.ok() ? result.value_or(absl::InternalError("GL worker: the job did not run"))
                     : status;
}

ContextInfo Worker::info() const {
  const std::lock_guard lock(mutex_);
  return info_;
}

int Worker::rebuild_count() const {
  const std::lock_guard lock(mutex_);
  return rebuild_count_;
}

// All GL objects go with the old context; the new one starts empty.
absl::Status Worker::Rebuild() {
  context_.reset();
  auto context = Context::Create(options_.context);
  const std::lock_guard lock(mutex_);
  context_status_ = context.status();
  if (context.ok()) {
    context_ = *std::move(context);
    info_ = context_->info();
  }
  return context_status_;
}

void Worker::RunEntry(Entry& entry) {
  constexpr int kAttempts = 2;
  absl::Status status = absl::UnavailableError("GL worker: no context");
  for (int attempt = 0; attempt < kAttempts && context_ != nullptr; ++attempt) {
    entry.job(*context_);
    if (!context_->IsLost()) {
      status = absl::OkStatus();
      break;
    }
    status = absl::UnavailableError("GL worker: the context was lost twice by the same job");
    if (absl::Status rebuilt = Rebuild(); !rebuilt.ok()) status = rebuilt;
    const std::lock_guard lock(mutex_);
    ++rebuild_count_;
  }
  if (entry.finish) entry.finish(status);
}

void Worker::Loop() {
  Rebuild().IgnoreError();  // Create reads context_status_
  {
    const std::lock_guard lock(mutex_);
    has_started_ = true;
  }
  wake_.notify_all();
  while (true) {
    std::unique_lock lock(mutex_);
    wake_.wait(lock, [&] { return is_stopping_ || !queue_.empty(); });
    if (queue_.empty()) break;
    Entry entry = std::move(queue_.front());
    queue_.pop_front();
    lock.unlock();
    RunEntry(entry);
  }
  context_.reset();
}

}  // namespace penumbra::gl
