// How long what a client sends now waits until the server reads it. Where the processor does not
// keep up, requests wait in sockets and in gRPC, which tell nobody of it; so this server sends
// itself messages, which take a connection and gRPC's threads like everybody's.
//
//   ReadDelay delay;
//   delay.OnRequest();              // for each: now and then it sends a message
//   if (delay.Now() > limit) …
//
// While few requests come, fewer than 400 a second, nothing is sent: they are not what keeps the
// processor busy.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>

namespace penumbra {

// Any thread may use it.
class ReadDelay {
 public:
  using Clock = std::chrono::steady_clock;

  // Where there is no socket to be had it measures nothing: there is never a delay.
  ReadDelay();
  ~ReadDelay();

  // Returns the request's lot, in [0, 1).
  double OnRequest();
  // Whether that request was to be refused because of Now().
  void OnAdmission(bool is_refused);

  // What the last message took, or the one under way is taking, where DelayTrend finds that to
  // last. Otherwise none.
  Clock::duration Now() const;

 private:
  class Loop;

  std::atomic<uint64_t> requests_{0};
  std::atomic<Clock::time_point> eighth_{};  // when the last came whose number eight divides
  std::atomic<Clock::time_point> many_{};    // when the last came that asked for a message
  std::unique_ptr<Loop> loop_;               // null: there is no socket
};

}  // namespace penumbra
