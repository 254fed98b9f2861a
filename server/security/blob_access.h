// Who may know of which blobs. A blob is named by its content, so saying that it is here says that
// somebody has it: to a caller whose scope is not everything there are those of the scenes in it,
// and those that the caller has uploaded.
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "absl/container/flat_hash_set.h"
#include "proto/convert/scene_convert.h"
#include "render/engine/engine.h"
#include "render/scene/content_hash.h"
#include "render/scene/scene.h"
#include "server/security/identity.h"

namespace penumbra {

// Any thread may use it.
class BlobAccess {
 public:
  explicit BlobAccess(Engine& engine) : engine_(engine) {}

  bool MaySee(const Identity& identity, const ContentHash& hash);
  // The identity has uploaded it, or was told that it is here. Of each name the last 16,384 are
  // remembered, of the last 1,024 names.
  void Remember(const Identity& identity, const ContentHash& hash);

 private:
  using Hashes = absl::flat_hash_set<ContentHash>;
  // Of a table of instances, which scenes share while none of them changes.
  struct InScene {
    std::weak_ptr<const Scene::Table<Instance>> instances;
    std::shared_ptr<const Hashes> hashes;
  };
  struct Uploads {
    Hashes hashes;
    std::deque<ContentHash> order;  // oldest first
  };

  std::shared_ptr<const Hashes> HashesOf(const std::string& scene_id);
  bool HasUploaded(const Identity& identity, const ContentHash& hash);

  Engine& engine_;
  std::mutex mutex_;
  std::map<std::string, InScene> scenes_;
  std::map<std::string, Uploads> uploads_;  // by the identity's name
  std::deque<std::string> names_;           // of uploads_, oldest first
};

// The blobs that a caller may name in a commit.
class BlobsInScope final : public BlobSource {
 public:
  BlobsInScope(const BlobSource& all, BlobAccess& access, const Identity& identity)
      : all_(all), access_(access), identity_(identity) {}

  std::shared_ptr<const Mesh> FindMesh(const ContentHash& hash) const override {
    return access_.MaySee(identity_, hash) ? all_.FindMesh(hash) : nullptr;
  }
  std::shared_ptr<const AlphaMask> FindMask(const ContentHash& hash) const override {
    return access_.MaySee(identity_, hash) ? all_.FindMask(hash) : nullptr;
  }

 private:
  const BlobSource& all_;
  BlobAccess& access_;
  const Identity& identity_;
};

}  // namespace penumbra
