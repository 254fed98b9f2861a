// Sends the newest of what it is given, no oftener than others can see it: a camera that is dragged
// at 1,000 Hz costs 20 messages a second, and the last one always goes.
//
//   NewestSender sender(kPresenceInterval, [&](const v1::Presence& newest) { Write(newest); });
//   sender.Offer(presence);  // never waits
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

#include "penumbra/v1/session.pb.h"

namespace penumbra {

// As often as a server tells others.
inline constexpr std::chrono::milliseconds kPresenceInterval{50};

class NewestSender {
 public:
  // `send` is called on a thread of its own, and may wait.
  NewestSender(std::chrono::milliseconds interval,
               std::function<void(const v1::Presence& newest)> send);
  ~NewestSender() { Close(); }
  NewestSender(const NewestSender&) = delete;
  NewestSender& operator=(const NewestSender&) = delete;

  // Any thread. What was offered before and not sent yet is left out; so is what equals the last
  // one sent.
  void Offer(v1::Presence presence);
  // No `send` after this; waits for one that runs. What was offered last may be left.
  void Close();

 private:
  void Run(const std::stop_token& stop);

  const std::chrono::milliseconds interval_;
  const std::function<void(const v1::Presence&)> send_;
  std::mutex mutex_;
  std::condition_variable_any offered_;
  std::optional<v1::Presence> waiting_;
  std::string sent_;  // the last one, serialized
  std::jthread thread_;
};

}  // namespace penumbra
