// A worker that is made when it is first asked for: a program that may need GL starts without it.
//
//   gl::LazyWorker lazy({.context = {.device = "software"}});
//   auto worker = lazy.Get();   // absl::StatusOr<gl::Worker*>
#pragma once

#include <memory>
#include <mutex>
#include <optional>

#include "absl/status/statusor.h"
#include "render/gl/worker.h"

namespace penumbra::gl {

class LazyWorker {
 public:
  explicit LazyWorker(WorkerOptions options) : options_(std::move(options)) {}

  // The same worker, or the same error, to every call. Any thread may ask; those that ask while it
  // is made wait for it.
  //
  // Errors  those of Worker::Create
  absl::StatusOr<Worker*> Get();

 private:
  const WorkerOptions options_;
  std::mutex mutex_;
  std::optional<absl::StatusOr<std::unique_ptr<Worker>>> worker_;
};

}  // namespace penumbra::gl
