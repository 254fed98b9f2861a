// A commit of a scene's history, and the hash that ties it to those before it. Deltas are bytes
// here: a server's files and archives keep the same ones, and so the same hashes.
#pragma once

#include <cstdint>
#include <string>

#include "render/scene/content_hash.h"
#include "render/scene/hashed_text.h"
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

// The chain after `commit`, whose delta has the hash `delta_hash`: two histories with equal chains
// have had the same commits.
ContentHash NextChain(const ContentHash& chain, const CommitRecord& commit,
                      const ContentHash& delta_hash);

}  // namespace penumbra
