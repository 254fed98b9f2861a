#include "render/scene/scene.h"

#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"
#include "render/scene/receiver_place.h"

namespace penumbra {
namespace {

template <typename T>
std::shared_ptr<const T> Find(const Scene::Table<T>& table, std::string_view id) {
  const auto found = table.find(id);
  return found == table.end() ? nullptr : found->second;
}

absl::Status UnknownReceiver(std::string_view id) {
  return FieldError(absl::StatusCode::kNotFound, "UNKNOWN_ID", "receiver_id",
                    absl::StrCat("found ", absl::string_view(id.data(), id.size()),
                                 ", need a receiver of the scene"));
}

}  // namespace

bool operator==(const Instance& a, const Instance& b) {
  const auto same_content = [](const auto& x, const auto& y) {
    return x == y || (x && y && x->id() == y->id());
  };
  return a.id == b.id && same_content(a.mesh, b.mesh) && a.world_from_mesh == b.world_from_mesh &&
         a.casts == b.casts && a.receives == b.receives && a.color == b.color &&
         same_content(a.alpha_mask, b.alpha_mask) && a.alpha_cutoff == b.alpha_cutoff;
}

bool SceneDelta::empty() const {
  return upsert_instances.empty() && remove_instances.empty() && upsert_lights.empty() &&
         remove_lights.empty() && upsert_receivers.empty() && remove_receivers.empty() &&
         !receive_on_planar_surfaces;
}

std::shared_ptr<const Scene> Scene::Empty(std::string id) {
  std::shared_ptr<Scene> scene(new Scene);
  scene->id_ = std::move(id);
  scene->instances_ = std::make_shared<Table<Instance>>();
  scene->casters_ = std::make_shared<CasterTreeOnDemand>();
  scene->lights_ = std::make_shared<Table<AreaLight>>();
  scene->receivers_ = std::make_shared<Table<Receiver>>();
  return scene;
}

std::shared_ptr<const Scene> Scene::WithRevision(Revision revision) const {
  std::shared_ptr<Scene> scene(new Scene(*this));
  scene->revision_ = revision;
  return scene;
}

std::shared_ptr<const Instance> Scene::FindInstance(std::string_view instance_id) const {
  return Find(*instances_, instance_id);
}

std::shared_ptr<const AreaLight> Scene::FindLight(std::string_view light_id) const {
  return Find(*lights_, light_id);
}

std::shared_ptr<const Receiver> Scene::FindReceiver(std::string_view receiver_id) const {
  return Find(*receivers_, receiver_id);
}

absl::StatusOr<ReceiverPatch> Scene::ResolveReceiver(std::string_view receiver_id) const {
  const auto receiver = FindReceiver(receiver_id);
  if (!receiver) return UnknownReceiver(receiver_id);
  const std::string* instance_id = InstanceOf(*receiver);
  const auto instance = instance_id == nullptr ? nullptr : FindInstance(*instance_id);
  return PlaceReceiver(*receiver, instance.get());
}

Aabb WorldBounds(const Instance& instance) {
  return TransformBounds(instance.world_from_mesh, instance.mesh->bounds());
}

Aabb Scene::Bounds() const {
  Aabb bounds;
  for (const auto& [id, instance] : *instances_) bounds.Add(WorldBounds(*instance));
  return bounds;
}

absl::Status CheckId(std::string_view id, std::string_view field_path) {
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '_' || c == '-';
  };
  const uint32_t limit = SceneLimits{}.max_id_bytes;
  const auto bad = std::find_if_not(id.begin(), id.end(), allowed);
  if (!id.empty() && id.size() <= limit && bad == id.end()) return absl::OkStatus();
  const std::string found = id.empty() ? "found nothing"
                            : id.size() > limit
                                ? absl::StrCat("found ", id.size(), " bytes")
                                : absl::StrCat("found byte ", static_cast<unsigned char>(*bad),
                                               " at position ", bad - id.begin());
  return FieldError(absl::StatusCode::kInvalidArgument, "BAD_ID", field_path,
                    absl::StrCat(found, ", need 1 to ", limit, " of A-Z a-z 0-9 . _ -"));
}

}  // namespace penumbra
