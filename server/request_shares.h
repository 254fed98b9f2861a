// Who it is that sends so much: where a server has to refuse part of what comes, those who send
// little need not suffer for those who send without end.
//
//   RequestShares shares;
//   const double share = shares.OnRequest(principal, session);   // 1: as many as others do
#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <mutex>
#include <string>

namespace penumbra {

// Any thread may use it.
class RequestShares {
 public:
  using Clock = std::chrono::steady_clock;

  // Counts a request. Returns how many its sender has sent in the last seconds, over how many a
  // sender has on average: as principals or as sessions, whichever is less. So a principal gains
  // nothing by many sessions, and a session is not taken for what others of its principal send.
  double OnRequest(const std::string& principal, const void* session,
                   Clock::time_point now = Clock::now());

 private:
  // Requests by sender, each second half as many.
  template <typename Sender>
  class Counts {
   public:
    double Add(const Sender& sender);  // returns the sender's share
    void Halve(int times);

   private:
    std::map<Sender, double> of_;
    double all_ = 0;
  };

  std::mutex mutex_;  // guards all below
  Clock::time_point halved_{};
  Counts<std::string> principals_;
  Counts<const void*> sessions_;
};

}  // namespace penumbra
