#include "render/engine/result_key.h"

#include "render/scene/hashed_text.h"

namespace penumbra {

std::optional<ContentHash> ResultKey(const Scene& scene, const ContentHash& surfaces,
                                     const ArtifactSpec& spec) {
  ArtifactSpec in_no_hurry = spec;
  in_no_hurry.time_budget_ms = 0;
  HashedText text;
  text.Add(SpecKey(in_no_hurry)).Add(surfaces);
  if (spec.light_id == kAllLights) {
    text.Add(scene.lights().size());
    for (const auto& [id, light] : scene.lights()) text.Add(HashOf(*light));
  } else {
    const auto light = scene.FindLight(spec.light_id);
    if (light == nullptr) return std::nullopt;
    text.Add(HashOf(*light));
  }
  if (InfoOf(spec.params).target == SpecTarget::kReceiver) {
    const auto receiver = scene.FindReceiver(spec.receiver_id);
    if (receiver == nullptr) return std::nullopt;
    text.Add(HashOf(*receiver));
  } else {
    for (const auto& [id, receiver] : scene.receivers()) {
      if (InstanceOf(*receiver) == nullptr) text.Add(HashOf(*receiver));
    }
  }
  return text.Hash();
}

ContentHash ResultKeys::SurfacesOf(const Scene& scene) {
  const std::shared_ptr<const InstanceTable> table = scene.shared_instances();
  {
    std::lock_guard lock(mutex_);
    if (const auto known = surfaces_.find(table); known != surfaces_.end()) return known->second;
  }
  const ContentHash hash = HashOfSurfaces(*table);
  std::lock_guard lock(mutex_);
  std::erase_if(surfaces_, [](const auto& known) { return known.first.expired(); });
  surfaces_.emplace(table, hash);
  return hash;
}

std::optional<ContentHash> ResultKeys::Of(const Scene& scene, const ArtifactSpec& spec) {
  return ResultKey(scene, SurfacesOf(scene), spec);
}

std::shared_ptr<const Artifact> AsComputedOn(const Scene& scene,
                                             std::shared_ptr<const Artifact> found) {
  const ArtifactHeader& was = found->header;
  if (was.scene_id == scene.id() && was.revision == scene.revision() &&
      was.scene_hash == scene.content_hash()) {
    return found;
  }
  auto as = std::make_shared<Artifact>(*found);
  as->header.scene_id = scene.id();
  as->header.revision = scene.revision();
  as->header.scene_hash = scene.content_hash();
  as->header.pass = 0;
  as->header.timings_ms.clear();
  return as;
}

}  // namespace penumbra
