#include "render/engine/scene_change.h"

#include <algorithm>

namespace penumbra {
namespace {

bool HaveTheSameSurface(const Instance& a, const Instance& b) {
  const bool same_mask = a.alpha_mask == b.alpha_mask ||
                         (a.alpha_mask && b.alpha_mask && a.alpha_mask->id() == b.alpha_mask->id());
  const bool same_cutoff = a.alpha_cutoff == b.alpha_cutoff || !a.alpha_mask;
  return a.casts == b.casts && a.mesh->id() == b.mesh->id() &&
         a.world_from_mesh == b.world_from_mesh && same_mask && same_cutoff;
}

bool CastTheSameShadow(const Instance& a, const Instance& b) {
  return (!a.casts && !b.casts) || HaveTheSameSurface(a, b);
}

// Receivers that stand by themselves are surfaces.
bool IsPatch(const std::shared_ptr<const Receiver>& receiver) {
  return receiver && InstanceOf(*receiver) == nullptr;
}

bool SameLight(const Scene& before, const Scene& after, const std::string& id) {
  const auto a = before.FindLight(id);
  const auto b = after.FindLight(id);
  return a != nullptr && b != nullptr && (a == b || *a == *b);
}

// Whether the scenes have the same lights, none more and none less.
bool SameLights(const Scene& before, const Scene& after) {
  const auto& lights = after.lights();
  return before.lights().size() == lights.size() &&
         std::all_of(lights.begin(), lights.end(),
                     [&](const auto& light) { return SameLight(before, after, light.first); });
}

// Whether the receiver, and the instance that it lies on, are the very same objects: then there is
// no need to find its place twice.
bool SharesReceiver(const Scene& before, const Scene& after, const std::string& id) {
  const auto receiver = after.FindReceiver(id);
  if (receiver == nullptr || before.FindReceiver(id) != receiver) return false;
  const std::string* instance_id = InstanceOf(*receiver);
  return instance_id == nullptr ||
         before.FindInstance(*instance_id) == after.FindInstance(*instance_id);
}

}  // namespace

SceneChange::SceneChange(const Scene& before, const Scene& after, const SceneDelta& delta)
    : before_(before), after_(after), delta_(delta) {}

bool SceneChange::Affects(const ArtifactSpec& spec, KnownShadowRegion& region) {
  const bool takes_all = spec.light_id == kAllLights;
  if (takes_all ? !SameLights(before_, after_) : !SameLight(before_, after_, spec.light_id)) {
    return true;
  }
  // What lies outside of a light's reach is not told apart here, and what does not cast is seen.
  if (InfoOf(spec.params).target != SpecTarget::kReceiver) {
    return ChangesSurfaces() || ChangesPatches();
  }
  const bool is_same_receiver = SharesReceiver(before_, after_, spec.receiver_id);
  const std::vector<Aabb>& changed = ChangedCasterBounds();
  if (is_same_receiver && changed.empty()) return false;
  const auto patch_after = after_.ResolveReceiver(spec.receiver_id);
  if (!patch_after.ok()) return true;
  if (!is_same_receiver) {
    const auto patch_before = before_.ResolveReceiver(spec.receiver_id);
    if (!patch_before.ok() || *patch_before != *patch_after) return true;
  }
  const auto meets = [&changed](const ShadowRegion& between) {
    return std::any_of(changed.begin(), changed.end(),
                       [&between](const Aabb& box) { return between.MayMeet(box); });
  };
  if (takes_all) {
    const auto& lights = after_.lights();
    return std::any_of(lights.begin(), lights.end(), [&](const auto& light) {
      return meets(ShadowRegion(*light.second, patch_after->patch));
    });
  }
  return meets(region.Between(after_.FindLight(spec.light_id), patch_after->patch));
}

bool SceneChange::ChangesSurfaces() const {
  const auto changes = [&](const std::string& id) {
    const auto a = before_.FindInstance(id);
    const auto b = after_.FindInstance(id);
    return !a || !b || (a != b && (a->receives != b->receives || !HaveTheSameSurface(*a, *b)));
  };
  return std::any_of(delta_.upsert_instances.begin(), delta_.upsert_instances.end(),
                     [&](const Instance& instance) { return changes(instance.id); }) ||
         std::any_of(delta_.remove_instances.begin(), delta_.remove_instances.end(), changes);
}

bool SceneChange::ChangesPatches() const {
  const auto changes = [&](const std::string& id) {
    const auto a = before_.FindReceiver(id);
    const auto b = after_.FindReceiver(id);
    return (IsPatch(a) || IsPatch(b)) && !(a == b || (a && b && *a == *b));
  };
  return delta_.receive_on_planar_surfaces ||
         std::any_of(delta_.upsert_receivers.begin(), delta_.upsert_receivers.end(),
                     [&](const Receiver& receiver) { return changes(receiver.id); }) ||
         std::any_of(delta_.remove_receivers.begin(), delta_.remove_receivers.end(), changes);
}

const std::vector<Aabb>& SceneChange::ChangedCasterBounds() {
  if (changed_caster_bounds_) return *changed_caster_bounds_;
  std::vector<Aabb>& bounds = changed_caster_bounds_.emplace();
  const auto add = [&](const std::string& id) {
    const auto a = before_.FindInstance(id);
    const auto b = after_.FindInstance(id);
    if (a && b && (a == b || CastTheSameShadow(*a, *b))) return;
    if (a && a->casts) bounds.push_back(WorldBounds(*a));
    if (b && b->casts) bounds.push_back(WorldBounds(*b));
  };
  for (const Instance& instance : delta_.upsert_instances) add(instance.id);
  for (const std::string& id : delta_.remove_instances) add(id);
  return bounds;
}

}  // namespace penumbra
