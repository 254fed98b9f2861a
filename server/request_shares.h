// Who it is that sends so much: where a server has to refuse part of what comes, those who send
// little need not suffer for those who send without end.
//
//   RequestShares shares;
//   const RequestShare share = shares.OnRequest(principal, session);
#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <mutex>
#include <string>

namespace penumbra {

// Of the last seconds.
struct RequestShare {
  // What a sender has sent, over what senders have on average: as principals or as sessions,
  // whichever is less. So a principal gains nothing by many sessions, and a session is not taken
  // for what others of its principal send.
  double of_mean = 1;
  size_t sessions = 1;  // that have sent
};

// Any thread may use it.
class RequestShares {
 public:
  using Clock = std::chrono::steady_clock;

  // Counts a request.
  RequestShare OnRequest(const std::string& principal, const void* session,
                         Clock::time_point now = Clock::now());

 private:
  // Requests by sender, each second half as many.
  template <typename Sender>
  class Counts {
   public:
    double Add(const Sender& sender);  // returns the sender's part of the mean
    void Halve(int times);
    size_t senders() const { return of_.size(); }

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
