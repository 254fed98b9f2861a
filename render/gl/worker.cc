#include "render/gl/worker.h"

#include <future>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"

namespace penumbra::gl {
namespace {

const char* DescriptionOf(Fault fault) {
  switch (fault) {
    case Fault::kNone:
      return "nothing happened";
    case Fault::kOverBudget:
      return "more GPU memory was asked for than there may be";
    case Fault::kOutOfMemory:
      return "GL was out of memory";
    case Fault::kError:
      return "GL reported an error";
    case Fault::kLost:
      return "the GL context was lost";
  }
  return "";
}

}  // namespace

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
  if (status.ok()) return result.value_or(absl::InternalError("GL worker: the job did not run"));
  // The job's own words on memory say how much it was.
  const bool is_memory = absl::IsResourceExhausted(status);
  return is_memory && result && FaultOf(*result) == FaultOf(status) ? *result : status;
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
absl::Status Worker::MakeContext() {
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

// What befell the job, if anything did.
absl::Status Worker::RunOnce(Entry& entry) {
  if (context_ != nullptr && context_->IsLost()) Mend(Fault::kLost);
  if (context_ == nullptr) {
    if (const absl::Status made = MakeContext(); !made.ok()) {
      return FaultError(Fault::kLost, absl::StrCat("GL worker: the context was lost and cannot be "
                                                   "made again: ",
                                                   made.message()));
    }
  }
  entry.job(*context_);
  context_->Check("gl::Worker").IgnoreError();  // noted as a fault
  const Fault fault = context_->TakeFault();
  return FaultError(fault, absl::StrCat("GL worker: ", DescriptionOf(fault), " twice by one job"));
}

void Worker::Mend(Fault fault) {
  if (fault == Fault::kOverBudget) {
    context_->DropKept();
    return;
  }
  if (fault != Fault::kOutOfMemory) health_.AddFailure(DescriptionOf(fault));
  // A context that cannot be made now may be for the next job.
  MakeContext().IgnoreError();
  const std::lock_guard lock(mutex_);
  ++rebuild_count_;
}

void Worker::RunEntry(Entry& entry) {
  constexpr int kAttempts = 2;
  absl::Status status;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    status = RunOnce(entry);
    if (status.ok()) {
      health_.AddSuccess();
      break;
    }
    Mend(FaultOf(status));
  }
  if (entry.finish) entry.finish(status);
}

void Worker::Loop() {
  MakeContext().IgnoreError();  // Create reads context_status_
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
