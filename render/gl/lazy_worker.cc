#include "render/gl/lazy_worker.h"

namespace penumbra::gl {

absl::StatusOr<Worker*> LazyWorker::Get() {
  const std::lock_guard lock(mutex_);
  if (!worker_) worker_ = Worker::Create(options_);
  if (!worker_->ok()) return worker_->status();
  return (*worker_)->get();
}

}  // namespace penumbra::gl
