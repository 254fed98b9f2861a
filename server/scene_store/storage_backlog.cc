#include "server/scene_store/storage_backlog.h"

#include <algorithm>

namespace penumbra {

void StorageBacklog::OnPosted(WrittenTo where, Clock::time_point now) {
  std::lock_guard lock(mutex_);
  Posted(where).push_back(now);
}

void StorageBacklog::OnTaken(WrittenTo where) {
  std::lock_guard lock(mutex_);
  Posted(where).pop_front();
}

StorageBacklog::Clock::duration StorageBacklog::Age(Clock::time_point now) const {
  std::lock_guard lock(mutex_);
  Clock::duration age(0);
  for (const auto* posted : {&for_files_, &for_journal_}) {
    if (!posted->empty()) age = std::max(age, now - posted->front());
  }
  return age;
}

void StorageBacklog::Add(const std::string& principal, uint64_t bytes) {
  std::lock_guard lock(mutex_);
  bytes_ += bytes;
  bytes_of_[principal] += bytes;
}

void StorageBacklog::Remove(const std::string& principal, uint64_t bytes) {
  std::lock_guard lock(mutex_);
  bytes_ -= bytes;
  const auto theirs = bytes_of_.find(principal);
  if (theirs == bytes_of_.end()) return;  // of an empty delta, after the principal's others
  theirs->second -= bytes;
  if (theirs->second == 0) bytes_of_.erase(theirs);
}

uint64_t StorageBacklog::BytesOf(const std::string& principal) const {
  std::lock_guard lock(mutex_);
  return Own(principal);
}

uint64_t StorageBacklog::ShareOf(const std::string& principal, uint64_t limit) const {
  std::lock_guard lock(mutex_);
  const uint64_t others = bytes_ - Own(principal);
  // Those who are let in at the same moment may pass the limit together.
  return (limit - std::min(limit, others)) / 2;
}

uint64_t StorageBacklog::Own(const std::string& principal) const {
  const auto theirs = bytes_of_.find(principal);
  return theirs == bytes_of_.end() ? 0 : theirs->second;
}

}  // namespace penumbra
