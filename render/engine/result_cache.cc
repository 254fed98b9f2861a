#include "render/engine/result_cache.h"

#include <iterator>
#include <utility>

#include "render/artifact/artifact_size.h"

namespace penumbra {

std::shared_ptr<const Artifact> ResultCache::Look(const ContentHash& key) {
  std::lock_guard lock(mutex_);
  const auto found = by_key_.find(key);
  if (found == by_key_.end()) return nullptr;
  results_.splice(results_.begin(), results_, found->second);
  return results_.front().artifact;
}

std::shared_ptr<const Artifact> ResultCache::FindInMemory(const ContentHash& key) {
  auto found = Look(key);
  if (found) ++found_in_memory_;
  return found;
}

std::shared_ptr<const Artifact> ResultCache::FindAnywhere(const ContentHash& key) {
  if (auto found = FindInMemory(key)) return found;
  auto loaded = options_.store ? options_.store->Load(key) : nullptr;
  if (!loaded) {
    ++not_found_;
    return nullptr;
  }
  ++found_in_store_;
  PutInMemory(key, loaded);
  return loaded;
}

void ResultCache::Keep(const std::string& slot, const ContentHash& key,
                       std::shared_ptr<const Artifact> artifact) {
  if (options_.store) options_.store->Save(slot, key, artifact);
  PutInMemory(key, std::move(artifact));
}

void ResultCache::PutInMemory(const ContentHash& key, std::shared_ptr<const Artifact> artifact) {
  const size_t bytes = BytesOf(*artifact);
  if (bytes > options_.max_bytes / kLargestPart) return;
  std::list<Result> leaving;  // ends after the lock: large artifacts take a while to free
  std::lock_guard lock(mutex_);
  if (by_key_.contains(key)) return;
  results_.push_front({key, std::move(artifact), bytes});
  by_key_.emplace(key, results_.begin());
  bytes_ += bytes;
  while (bytes_ > options_.max_bytes) {
    bytes_ -= results_.back().bytes;
    by_key_.erase(results_.back().key);
    leaving.splice(leaving.end(), results_, std::prev(results_.end()));
  }
}

ResultStatistics ResultCache::statistics() const {
  std::lock_guard lock(mutex_);
  return {.found_in_memory = found_in_memory_,
          .found_in_store = found_in_store_,
          .not_found = not_found_,
          .bytes = bytes_};
}

}  // namespace penumbra
