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

namespace penumbra {
namespace {

// The bytes by which an object counts in a scene's hash. −0 is written as 0.
class Bytes {
 public:
  void Put(const std::string& text) {
    Put(static_cast<uint32_t>(text.size()));
    Append(text.data(), text.size());
  }
  void Put(const ContentHash& hash) { Append(hash.bytes.data(), hash.bytes.size()); }
  void Put(float x) {
    x += 0.0f;
    Append(&x, sizeof(x));
  }
  void Put(Vec3 v) {
    for (int c = 0; c < 3; ++c) Put(v[c]);
  }
  void Put(uint32_t x) { Append(&x, sizeof(x)); }
  void Put(bool x) { Put(uint32_t{x}); }

  ContentHash Hash() const { return Sha256(std::as_bytes(std::span(bytes_))); }

 private:
  void Append(const void* data, size_t size) {
    bytes_.append(static_cast<const char*>(data), size);
  }

  std::string bytes_;
};

void PutShape(Bytes& out, const RectangleLight& s) {
  for (const Vec3& v : {s.corner, s.edge_u, s.edge_v, s.radiance}) out.Put(v);
  out.Put(s.two_sided);
}
void PutShape(Bytes& out, const DiskLight& s) {
  for (const Vec3& v : {s.center, s.normal, s.radiance}) out.Put(v);
  out.Put(s.radius);
  out.Put(s.two_sided);
}
void PutShape(Bytes& out, const SphereLight& s) {
  for (const Vec3& v : {s.center, s.radiance}) out.Put(v);
  out.Put(s.radius);
}
void PutShape(Bytes& out, const PointLight& s) {
  for (const Vec3& v : {s.position, s.intensity}) out.Put(v);
}
void PutShape(Bytes& out, const SpotLight& s) {
  for (const Vec3& v : {s.position, s.direction, s.intensity}) out.Put(v);
  out.Put(s.inner_angle);
  out.Put(s.outer_angle);
}
void PutShape(Bytes& out, const DistantLight& s) {
  for (const Vec3& v : {s.to_light, s.irradiance}) out.Put(v);
  out.Put(s.angular_diameter);
}
void PutShape(Bytes& out, const Parallelogram& s) {
  for (const Vec3& v : {s.origin, s.edge_u, s.edge_v}) out.Put(v);
}
void PutShape(Bytes& out, const PlanarInstance& s) { out.Put(s.instance_id); }

ContentHash HashOf(const Instance& instance) {
  Bytes out;
  out.Put(uint32_t{'I'});
  out.Put(instance.id);
  out.Put(instance.mesh->id());
  for (int column = 0; column < 4; ++column) out.Put(instance.world_from_mesh[column]);
  out.Put(instance.casts);
  out.Put(instance.receives);
  out.Put(instance.color);
  out.Put(instance.alpha_mask != nullptr);
  if (instance.alpha_mask) out.Put(instance.alpha_mask->id());
  out.Put(instance.alpha_cutoff);
  return out.Hash();
}

ContentHash HashOf(const AreaLight& light) {
  Bytes out;
  out.Put(uint32_t{'L'});
  out.Put(light.id);
  out.Put(static_cast<uint32_t>(light.shape.index()));
  std::visit([&out](const auto& shape) { PutShape(out, shape); }, light.shape);
  return out.Hash();
}

ContentHash HashOf(const Receiver& receiver) {
  Bytes out;
  out.Put(uint32_t{'R'});
  out.Put(receiver.id);
  out.Put(static_cast<uint32_t>(receiver.shape.index()));
  std::visit([&out](const auto& shape) { PutShape(out, shape); }, receiver.shape);
  out.Put(receiver.width);
  out.Put(receiver.height);
  out.Put(receiver.two_sided);
  out.Put(receiver.reflectance);
  return out.Hash();
}

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

// Where in `delta` the receiver, or the instance that it lies on, was brought or taken away.
std::string PathOfCause(const SceneDelta& delta, const std::string& receiver_id,
                        const std::string& instance_id) {
  for (size_t i = 0; i < delta.upsert_receivers.size(); ++i) {
    if (delta.upsert_receivers[i].id == receiver_id) {
      return absl::StrCat("upsert_receivers[", i, "].instance_id");
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

// Whether every receiver that `delta` touches still has a plane to lie in.
absl::Status CheckPlanes(const Scene& scene, const SceneDelta& delta) {
  const Touched touched(delta);
  for (const auto& [id, receiver] : scene.receivers()) {
    const auto* planar = std::get_if<PlanarInstance>(&receiver->shape);
    if (!planar || !touched.Has(id, planar->instance_id)) continue;
    if (const auto patch = scene.ResolveReceiver(id); !patch.ok()) {
      const std::string path = PathOfCause(delta, id, planar->instance_id);
      return FieldError(
          patch.status().code(), ErrorReason(patch.status()), path,
          absl::StrCat("receiver ", id, " would lose its plane: ", patch.status().message()));
    }
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

  if (const auto status = CheckPlanes(*next, delta); !status.ok()) return status;
  return next;
}

}  // namespace penumbra
