#include "server/security/blob_access.h"

#include <utility>

namespace penumbra {
namespace {

constexpr size_t kMaxUploads = 16'384;  // as many as one request may ask for
constexpr size_t kMaxNames = 1'024;

}  // namespace

bool BlobAccess::MaySee(const Identity& identity, const ContentHash& hash) {
  if (identity.scope.is_everything() || HasUploaded(identity, hash)) return true;
  const auto infos = engine_.ListScenes();
  if (!infos.ok()) return false;
  for (const SceneInfo& info : *infos) {
    if (!identity.scope.Contains(info.id)) continue;
    const auto hashes = HashesOf(info.id);
    if (hashes && hashes->contains(hash)) return true;
  }
  return false;
}

std::shared_ptr<const BlobAccess::Hashes> BlobAccess::HashesOf(const std::string& scene_id) {
  const auto scene = engine_.Snapshot(scene_id);
  std::lock_guard lock(mutex_);
  if (!scene.ok()) {
    scenes_.erase(scene_id);
    return nullptr;
  }
  const auto instances = (*scene)->shared_instances();
  InScene& known = scenes_[scene_id];
  if (known.hashes && known.instances.lock() == instances) return known.hashes;
  auto hashes = std::make_shared<Hashes>();
  for (const auto& [id, instance] : *instances) {
    hashes->insert(instance->mesh->id());
    if (instance->alpha_mask) hashes->insert(instance->alpha_mask->id());
  }
  known = {instances, hashes};
  return hashes;
}

bool BlobAccess::HasUploaded(const Identity& identity, const ContentHash& hash) {
  std::lock_guard lock(mutex_);
  const auto found = uploads_.find(identity.name);
  return found != uploads_.end() && found->second.hashes.contains(hash);
}

void BlobAccess::Remember(const Identity& identity, const ContentHash& hash) {
  if (identity.scope.is_everything()) return;
  std::lock_guard lock(mutex_);
  const auto [found, is_new] = uploads_.try_emplace(identity.name);
  if (is_new) names_.push_back(identity.name);
  if (names_.size() > kMaxNames) {
    uploads_.erase(names_.front());
    names_.pop_front();
  }
  Uploads& uploads = found->second;
  if (!uploads.hashes.insert(hash).second) return;
  uploads.order.push_back(hash);
  if (uploads.order.size() <= kMaxUploads) return;
  uploads.hashes.erase(uploads.order.front());
  uploads.order.pop_front();
}

}  // namespace penumbra
