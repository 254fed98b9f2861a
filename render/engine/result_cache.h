// Final artifacts that were computed, found again by what they depend on (result_key.h): by whoever
// undoes an edit, comes back to a scene, or asks for the same of a scene that is equal.
//
//   ResultCache results({.max_bytes = size_t{128} << 20});
//   const auto key = results.KeyOf(scene, spec);
//   auto known = results.FindAnywhere(*key);
//   if (!known) results.Keep(slot, key, Compute());
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "render/artifact/artifact.h"
#include "render/engine/result_key.h"
#include "render/scene/content_hash.h"
#include "render/scene/scene.h"
#include "render/technique/artifact_spec.h"

namespace penumbra {

// Where results outlast memory. Any thread may call it.
class ResultStore {
 public:
  virtual ~ResultStore() = default;
  // Null: it has none. May wait for a disk.
  virtual std::shared_ptr<const Artifact> Load(const ContentHash& key) = 0;
  // Does not block, and may store nothing. Artifacts of one slot replace one another: when they
  // come fast, those in between need not be stored.
  virtual void Save(const std::string& slot, const ContentHash& key,
                    std::shared_ptr<const Artifact> artifact) = 0;
};

struct ResultCacheOptions {
  size_t max_bytes = 0;          // in memory; 0: none
  ResultStore* store = nullptr;  // null: none. It outlives the cache
};

struct ResultStatistics {
  uint64_t found_in_memory = 0;
  uint64_t found_in_store = 0;
  uint64_t not_found = 0;
  size_t bytes = 0;  // in memory
};

class ResultCache {
 public:
  // Of what is in memory no artifact takes more than this part: one map must not cost all others.
  static constexpr size_t kLargestPart = 4;

  explicit ResultCache(const ResultCacheOptions& options) : options_(options) {}

  bool is_on() const { return options_.max_bytes > 0 || options_.store != nullptr; }

  std::optional<ContentHash> KeyOf(const Scene& scene, const ArtifactSpec& spec) {
    return keys_.Of(scene, spec);
  }
  // What is in memory; null: nothing. A miss is not counted, since another look may follow.
  std::shared_ptr<const Artifact> FindInMemory(const ContentHash& key);
  // Also from the store, for which it may wait.
  std::shared_ptr<const Artifact> FindAnywhere(const ContentHash& key);
  // `slot` names what the artifact is the newest of, see ResultStore.
  void Keep(const std::string& slot, const ContentHash& key,
            std::shared_ptr<const Artifact> artifact);

  ResultStatistics statistics() const;

 private:
  struct Result {
    ContentHash key;
    std::shared_ptr<const Artifact> artifact;
    size_t bytes;
  };

  std::shared_ptr<const Artifact> Look(const ContentHash& key);
  void PutInMemory(const ContentHash& key, std::shared_ptr<const Artifact> artifact);

  const ResultCacheOptions options_;
  ResultKeys keys_;
  mutable std::mutex mutex_;
  std::list<Result> results_;  // the one used last first
  std::map<ContentHash, std::list<Result>::iterator> by_key_;
  size_t bytes_ = 0;
  std::atomic<uint64_t> found_in_memory_{0}, found_in_store_{0}, not_found_{0};
};

}  // namespace penumbra
