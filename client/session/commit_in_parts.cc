#include "client/session/commit_in_parts.h"

#include <algorithm>
#include <iterator>
#include <utility>
#include <variant>
#include <vector>

#include "render/scene/field_error.h"

namespace penumbra {
namespace {

// Said by the client of what no message holds, and by the server of what it does not take in one.
bool IsTooLarge(const absl::Status& status) {
  const std::string reason = ErrorReason(status);
  return reason == "QUOTA_MESSAGE" || reason == "QUOTA_MESSAGE_BYTES" || reason == "QUOTA_ELEMENTS";
}

size_t ObjectCount(const SceneDelta& delta) {
  return delta.upsert_instances.size() + delta.remove_instances.size() +
         delta.upsert_lights.size() + delta.remove_lights.size() + delta.upsert_receivers.size() +
         delta.remove_receivers.size();
}

// Moves up to `count` objects, and counts them off.
template <typename T>
void Move(std::vector<T>& from, std::vector<T>& to, size_t& count) {
  const auto end = from.begin() + static_cast<ptrdiff_t>(std::min(count, from.size()));
  to.assign(std::make_move_iterator(from.begin()), std::make_move_iterator(end));
  count -= to.size();
  from.erase(from.begin(), end);
}

// Takes the first `count` objects out of `delta`, in an order in which no receiver loses its plane.
SceneDelta TakeFirst(SceneDelta& delta, size_t count) {
  SceneDelta first;
  first.base_revision = std::exchange(delta.base_revision, std::nullopt);
  Move(delta.remove_receivers, first.remove_receivers, count);
  Move(delta.remove_instances, first.remove_instances, count);
  Move(delta.remove_lights, first.remove_lights, count);
  Move(delta.upsert_instances, first.upsert_instances, count);
  Move(delta.upsert_lights, first.upsert_lights, count);
  Move(delta.upsert_receivers, first.upsert_receivers, count);
  return first;
}

absl::StatusOr<Revision> CommitHalves(Engine& engine, const std::string& scene_id,
                                      SceneDelta delta) {
  auto revision = engine.Commit(scene_id, delta);
  const size_t count = ObjectCount(delta);
  if (count < 2 || !IsTooLarge(revision.status())) return revision;
  revision = CommitHalves(engine, scene_id, TakeFirst(delta, count / 2));
  if (!revision.ok()) return revision;
  return CommitHalves(engine, scene_id, std::move(delta));
}

// What `delta` removes, with the receivers that it puts elsewhere.
SceneDelta Removals(const SceneDelta& delta, const Scene& scene) {
  SceneDelta removals;
  removals.base_revision = delta.base_revision;
  removals.remove_instances = delta.remove_instances;
  removals.remove_lights = delta.remove_lights;
  removals.remove_receivers = delta.remove_receivers;
  for (const Receiver& receiver : delta.upsert_receivers) {
    const auto present = scene.FindReceiver(receiver.id);
    if (present && std::holds_alternative<PlanarInstance>(present->shape)) {
      removals.remove_receivers.push_back(receiver.id);
    }
  }
  return removals;
}

}  // namespace

absl::StatusOr<Revision> CommitInParts(Engine& engine, const std::string& scene_id,
                                       const SceneDelta& delta) {
  const auto whole = engine.Commit(scene_id, delta);
  if (!IsTooLarge(whole.status())) return whole;
  const auto scene = engine.Snapshot(scene_id);
  if (!scene.ok()) return scene.status();
  SceneDelta upserts = delta;
  SceneDelta removals = Removals(delta, **scene);
  upserts.remove_instances.clear();
  upserts.remove_lights.clear();
  upserts.remove_receivers.clear();
  if (!removals.empty()) {
    upserts.base_revision.reset();
    const auto removed = CommitHalves(engine, scene_id, std::move(removals));
    if (!removed.ok() || upserts.empty()) return removed;
  }
  return CommitHalves(engine, scene_id, std::move(upserts));
}

}  // namespace penumbra
