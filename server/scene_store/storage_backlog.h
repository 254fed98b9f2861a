// Whether the disk keeps up with the commits of all scenes: how many bytes of whose are on their
// way to it, and for how long the scenes that wait for a writer have waited.
//
//   backlog.OnPosted(WrittenTo::kFile, now);  // a scene has commits to be written
//   backlog.OnTaken(WrittenTo::kFile);        // the first of those that wait has got a writer
//   if (backlog.Age(now) > limit) …
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <string>

namespace penumbra {

enum class WrittenTo : uint8_t { kFile, kJournal };

// Any thread may use it.
class StorageBacklog {
 public:
  using Clock = std::chrono::steady_clock;

  void OnPosted(WrittenTo where, Clock::time_point now);
  // Writers take the scenes of each kind in the order in which they were posted.
  void OnTaken(WrittenTo where);
  // Of the scene that has waited longest; 0 where none waits.
  Clock::duration Age(Clock::time_point now) const;

  void Add(const std::string& principal, uint64_t bytes);
  void Remove(const std::string& principal, uint64_t bytes);
  uint64_t BytesOf(const std::string& principal) const;
  // How many the principal may have: half of what the others leave of `limit`.
  uint64_t ShareOf(const std::string& principal, uint64_t limit) const;

 private:
  // With the lock held, as for the next.
  std::deque<Clock::time_point>& Posted(WrittenTo where) {
    return where == WrittenTo::kFile ? for_files_ : for_journal_;
  }
  uint64_t Own(const std::string& principal) const;

  mutable std::mutex mutex_;
  std::deque<Clock::time_point> for_files_, for_journal_;
  uint64_t bytes_ = 0;                        // of all
  std::map<std::string, uint64_t> bytes_of_;  // of those who have some
};

}  // namespace penumbra
