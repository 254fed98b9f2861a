// What is kept of a scene on disk, and the hashes that hold it together. Deltas are bytes here.
#pragma once

#include <string>

#include "render/scene/commit_record.h"
#include "render/scene/content_hash.h"
#include "render/scene/scene.h"

namespace penumbra {

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
ContentHash HashOf(const SnapshotRecord& snapshot);
// Over what a file says it is about, how far it goes, and in which journal there may be more.
ContentHash SealOf(const SceneIdentity& identity, const SceneHead& head,
                   const std::string& journal);

}  // namespace penumbra
