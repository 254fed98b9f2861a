#include "client/cli/replace_scene.h"

#include <memory>
#include <set>
#include <string>
#include <vector>

namespace penumbra {
namespace {

template <typename T>
void Replace(const Scene::Table<T>& present, const std::vector<T>& wanted, std::vector<T>& upserts,
             std::vector<std::string>& removals) {
  std::set<std::string_view> kept;
  for (const T& object : wanted) {
    kept.insert(object.id);
    const auto found = present.find(object.id);
    if (found == present.end() || !(*found->second == object)) upserts.push_back(object);
  }
  for (const auto& [id, object] : present) {
    if (!kept.contains(id)) removals.push_back(id);
  }
}

// Those named and, where asked for, one on each planar surface: the removals must know them.
std::vector<Receiver> WantedReceivers(const SceneDelta& wanted) {
  std::vector<Receiver> receivers = wanted.upsert_receivers;
  if (!wanted.receive_on_planar_surfaces) return receivers;
  InstanceTable instances;
  for (const Instance& instance : wanted.upsert_instances) {
    instances[instance.id] = std::make_shared<const Instance>(instance);
  }
  const auto found =
      ReceiversOnSurfaces(instances, *wanted.receive_on_planar_surfaces, "", SceneLimits{});
  if (found.ok()) receivers.insert(receivers.end(), found->begin(), found->end());
  return receivers;
}

}  // namespace

SceneDelta ReplacementDelta(const Scene& scene, const SceneDelta& wanted) {
  SceneDelta delta;
  Replace(scene.instances(), wanted.upsert_instances, delta.upsert_instances,
          delta.remove_instances);
  Replace(scene.lights(), wanted.upsert_lights, delta.upsert_lights, delta.remove_lights);
  Replace(scene.receivers(), WantedReceivers(wanted), delta.upsert_receivers,
          delta.remove_receivers);
  return delta;
}

}  // namespace penumbra
