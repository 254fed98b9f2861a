// Scene::Apply: check a delta, then make the next snapshot.

#include <set>
#include <span>
#include <string>
#include <type_traits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"
#include "render/scene/scene.h"
#include "render/scene/scene_check.h"
#include "render/scene/scene_hash.h"

namespace penumbra {
namespace {

// One kind of object of a delta: what it adds, what it takes away, and how it is called.
template <typename T>
struct Change {
  const std::vector<T>& upserts;
  const std::vector<std::string>& removals;
  const char* plural;
  const char* quota_reason;
  uint64_t limit;
  absl::Status (*check)(const T&, std::string_view, const SceneLimits&);

  std::string UpsertPath(size_t i) const { return absl::StrCat("upsert_", plural, "[", i, "]"); }
  std::string RemovalPath(size_t i) const { return absl::StrCat("remove_", plural, "[", i, "]"); }
};

absl::Status DuplicateId(std::string path, const std::string& id) {
  return FieldError(absl::StatusCode::kInvalidArgument, "DUPLICATE_ID", path,
                    absl::StrCat("found ", id, " a second time, need each id once in a delta"));
}

// The table after `change`, and `hash` brought up to date. The old table is shared when nothing
// changes.
template <typename T>
absl::StatusOr<std::shared_ptr<const Scene::Table<T>>> ApplyChange(
    const std::shared_ptr<const Scene::Table<T>>& table, const Change<T>& change,
    const SceneLimits& limits, ContentHash& hash) {
  if (change.upserts.empty() && change.removals.empty()) return table;
  auto next = std::make_shared<Scene::Table<T>>(*table);
  std::set<std::string_view> seen;
  for (size_t i = 0; i < change.removals.size(); ++i) {
    const std::string& id = change.removals[i];
    if (!seen.insert(id).second) return DuplicateId(change.RemovalPath(i), id);
    const auto found = next->find(id);
    if (found == next->end()) {
      return FieldError(absl::StatusCode::kNotFound, "UNKNOWN_ID", change.RemovalPath(i),
                        absl::StrCat("found ", id, ", need one of the scene's ", change.plural));
    }
    hash = Combine(hash, HashOf(*found->second));
    next->erase(found);
  }
  for (size_t i = 0; i < change.upserts.size(); ++i) {
    const T& object = change.upserts[i];
    if (const auto status = change.check(object, change.UpsertPath(i), limits); !status.ok()) {
      return status;
    }
    if (!seen.insert(object.id).second) {
      return DuplicateId(change.UpsertPath(i) + ".id", object.id);
    }
    std::shared_ptr<const T>& slot = (*next)[object.id];
    if (slot) hash = Combine(hash, HashOf(*slot));
    slot = std::make_shared<const T>(object);
    hash = Combine(hash, HashOf(object));
  }
  if (next->size() > change.limit) {
    return FieldError(absl::StatusCode::kResourceExhausted, change.quota_reason,
                      absl::StrCat("upsert_", change.plural),
                      absl::StrCat("found ", next->size(), " ", change.plural,
                                   " after the commit, need at most ", change.limit));
  }
  return next;
}

absl::Status CheckBase(std::optional<Revision> base, Revision current) {
  if (!base || *base == current) return absl::OkStatus();
  const bool behind = *base < current;
  return FieldError(behind ? absl::StatusCode::kAborted : absl::StatusCode::kOutOfRange,
                    behind ? "STALE_BASE" : "FUTURE_BASE", "base_revision",
                    absl::StrCat("found ", *base, ", need the current revision ", current));
}

absl::Status CheckTriangles(const Scene::Table<Instance>& instances, const SceneLimits& limits) {
  uint64_t triangles = 0;
  for (const auto& [id, instance] : instances) triangles += instance->mesh->triangle_count();
  if (triangles <= limits.max_triangles_per_scene) return absl::OkStatus();
  return FieldError(absl::StatusCode::kResourceExhausted, "QUOTA_SCENE_TRIANGLES",
                    "upsert_instances",
                    absl::StrCat("found ", triangles,
                                 " placed triangles after the commit, need at "
                                 "most ",
                                 limits.max_triangles_per_scene));
}

// What receivers' places depend on: the receivers and instances that a delta brings or takes away.
class Touched {
 public:
  explicit Touched(const SceneDelta& delta) {
    for (const Receiver& receiver : delta.upsert_receivers) receivers_.insert(receiver.id);
    for (const Instance& instance : delta.upsert_instances) instances_.insert(instance.id);
    for (const std::string& id : delta.remove_instances) instances_.insert(id);
  }
  bool Has(std::string_view receiver_id, std::string_view instance_id) const {
    return receivers_.contains(receiver_id) || instances_.contains(instance_id);
  }

 private:
  std::set<std::string_view> receivers_, instances_;
};

// Where in `delta` the receiver, of which `field` is at fault, or the instance that it lies on was
// brought or taken away.
std::string PathOfCause(const SceneDelta& delta, const std::string& receiver_id,
                        const std::string& instance_id, const std::string& field) {
  for (size_t i = 0; i < delta.upsert_receivers.size(); ++i) {
    if (delta.upsert_receivers[i].id == receiver_id) {
      return absl::StrCat("upsert_receivers[", i, "].", field);
    }
  }
  for (size_t i = 0; i < delta.remove_instances.size(); ++i) {
    if (delta.remove_instances[i] == instance_id) return absl::StrCat("remove_instances[", i, "]");
  }
  for (size_t i = 0; i < delta.upsert_instances.size(); ++i) {
    if (delta.upsert_instances[i].id == instance_id)
      return absl::StrCat("upsert_instances[", i, "]");
  }
  return "";
}

// What finding the surface that `receiver` names would cost a commit, if it is too much.
absl::Status CheckSurfaceCost(const Receiver& receiver, const Scene& scene,
                              const SceneLimits& limits) {
  const auto* surface = std::get_if<PlanarSurface>(&receiver.shape);
  if (surface == nullptr) return absl::OkStatus();
  const auto instance = scene.FindInstance(surface->instance_id);
  if (!instance || instance->mesh->triangle_count() <= limits.max_surface_triangles) {
    return absl::OkStatus();
  }
  return FieldError(
      absl::StatusCode::kResourceExhausted, "QUOTA_SURFACE_TRIANGLES", "instance_id",
      absl::StrCat("found ", surface->instance_id, " of ", instance->mesh->triangle_count(),
                   " triangles, need at most ", limits.max_surface_triangles));
}

// Whether each receiver that `delta` brings, or whose instance it touches, has a place in `next`.
absl::Status CheckPlaces(const SceneDelta& delta, const Scene& next, const SceneLimits& limits) {
  const Touched touched(delta);
  for (const auto& [id, receiver] : next.receivers()) {
    const std::string* instance_id = InstanceOf(*receiver);
    if (instance_id == nullptr || !touched.Has(id, *instance_id)) continue;
    absl::Status status = CheckSurfaceCost(*receiver, next, limits);
    if (status.ok()) status = next.ResolveReceiver(id).status();
    if (status.ok()) continue;
    return FieldError(status.code(), ErrorReason(status),
                      PathOfCause(delta, id, *instance_id, ErrorFieldPath(status)),
                      absl::StrCat("receiver ", id, " would lose its plane: ", status.message()));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::shared_ptr<const Scene>> Scene::Apply(const SceneDelta& delta,
                                                          const SceneLimits& limits) const {
  if (const auto status = CheckBase(delta.base_revision, revision_); !status.ok()) return status;

  std::shared_ptr<Scene> next(new Scene(*this));
  ++next->revision_;
  const Change<Instance> instance_change{
      delta.upsert_instances, delta.remove_instances, "instances",
      "QUOTA_INSTANCES",      limits.max_instances,   CheckInstance};
  auto instances = ApplyChange(instances_, instance_change, limits, next->content_hash_);
  if (!instances.ok()) return instances.status();
  if (*instances != instances_) next->casters_ = std::make_shared<CasterTreeOnDemand>();
  next->instances_ = *std::move(instances);
  if (const auto status = CheckTriangles(*next->instances_, limits); !status.ok()) return status;

  const Change<AreaLight> light_change{delta.upsert_lights, delta.remove_lights, "lights",
                                       "QUOTA_LIGHTS",      limits.max_lights,   CheckLight};
  auto lights = ApplyChange(lights_, light_change, limits, next->content_hash_);
  if (!lights.ok()) return lights.status();
  next->lights_ = *std::move(lights);

  const Change<Receiver> receiver_change{
      delta.upsert_receivers, delta.remove_receivers, "receivers",
      "QUOTA_RECEIVERS",      limits.max_receivers,   CheckReceiver};
  auto receivers = ApplyChange(receivers_, receiver_change, limits, next->content_hash_);
  if (!receivers.ok()) return receivers.status();
  next->receivers_ = *std::move(receivers);

  if (const auto status = next->AddSurfaceReceivers(delta, limits); !status.ok()) return status;
  if (const auto status = CheckPlaces(delta, *next, limits); !status.ok()) return status;
  return next;
}

absl::Status Scene::AddSurfaceReceivers(const SceneDelta& delta, const SceneLimits& limits) {
  if (!delta.receive_on_planar_surfaces) return absl::OkStatus();
  const std::string path = "receive_on_planar_surfaces";
  const auto found =
      ReceiversOnSurfaces(*instances_, *delta.receive_on_planar_surfaces, path, limits);
  if (!found.ok()) return found.status();
  const std::vector<std::string> none;
  const Change<Receiver> change{
      *found, none, "receivers", "QUOTA_RECEIVERS", limits.max_receivers, CheckReceiver};
  auto receivers = ApplyChange(receivers_, change, limits, content_hash_);
  if (!receivers.ok()) {
    return FieldError(receivers.status().code(), ErrorReason(receivers.status()), path,
                      std::string(receivers.status().message()));
  }
  receivers_ = *std::move(receivers);
  return absl::OkStatus();
}

}  // namespace penumbra
