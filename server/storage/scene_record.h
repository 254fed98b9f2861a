// What is kept of a scene on disk, and the hashes that hold it together. Deltas are bytes here.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "render/scene/content_hash.h"
#include "render/scene/scene.h"

namespace penumbra {

// A commit as it is kept.
struct CommitRecord {
  Revision revision = 0;
  ContentHash content_hash;  // of the scene after it
  std::string key;           // idempotency key; empty: none
  ContentHash fingerprint;   // of the delta as the client sent it, where there is a key
  std::string author;        // the client's name
  int64_t time_ms = 0;       // since 1970, UTC
  std::string delta;         // v1.SceneDelta; empty where history has been compacted
};

// A whole scene as it is kept.
struct SnapshotRecord {
  Revision revision = 0;
  ContentHash content_hash;
  std::string body;  // v1.SceneDelta from the empty scene
};

// What a scene's file is about.
struct SceneIdentity {
  std::string scene_id;
  std::string incarnation;  // 16 random bytes: different for every scene ever made
  std::string owner;        // 16 random bytes: the data directory's
};

// The newest commit, and the hash over all commits up to it.
struct SceneHead {
  Revision revision = 0;
  ContentHash chain;

  bool operator==(const SceneHead&) const = default;
};

// The chain before the first commit.
ContentHash FirstChain(const SceneIdentity& identity);
// The chain after `commit`, whose delta has the hash `delta_hash`: two scenes with equal chains
// have had the same commits.
ContentHash NextChain(const ContentHash& chain, const CommitRecord& commit,
                      const ContentHash& delta_hash);
ContentHash HashOf(const SnapshotRecord& snapshot);
// Over what a file says it is about and how far it goes.
ContentHash SealOf(const SceneIdentity& identity, const SceneHead& head);

ContentHash HashOfBytes(std::string_view bytes);
std::string_view BytesOf(const ContentHash& hash);

}  // namespace penumbra
