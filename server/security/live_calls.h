// The streams that are open, so that each ends soon after its caller's right to it does.
//
//   auto live = calls.Add([…] { return guard.StillAllows(…); }, [session] { session->End(…); },
//                         context);
//   live->Finish();   // before the context is gone
//
// Sweep, once a second, asks each whether it may go on. One that may not is told to end; two
// seconds later, if its client has not read that, its call is cancelled.
#pragma once

#include <chrono>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <optional>

#include "absl/status/status.h"
#include "grpcpp/server_context.h"

namespace penumbra {

class LiveCall {
 public:
  using Check = std::function<absl::Status()>;
  using End = std::function<void(const absl::Status&)>;

  LiveCall(Check check, End end, grpc::CallbackServerContext* context)
      : check_(std::move(check)), end_(std::move(end)), context_(context) {}

  // The call is over. Waits for a sweep that is at it.
  void Finish();

  // Whether it may go on, asked now: before something that cannot be taken back.
  absl::Status StillAllowed();

 private:
  friend class LiveCalls;
  void Sweep(std::chrono::steady_clock::time_point now);

  const Check check_;
  const End end_;
  std::mutex mutex_;
  grpc::CallbackServerContext* context_;  // null once finished
  std::optional<std::chrono::steady_clock::time_point> told_;
};

class LiveCalls {
 public:
  // `end` may be called while a Finish of the same call waits for it, and so must not wait for
  // that. It may be null: then the call is cancelled at once.
  std::shared_ptr<LiveCall> Add(LiveCall::Check check, LiveCall::End end,
                                grpc::CallbackServerContext* context);
  void Sweep(std::chrono::steady_clock::time_point now);

 private:
  std::mutex mutex_;
  std::list<std::weak_ptr<LiveCall>> calls_;
};

}  // namespace penumbra
