#include "client/cli/object_edit.h"

#include <utility>
#include <variant>
#include <vector>

#include "client/cli/option_error.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

// False: it has no place.
struct MoveBy {
  Vec3 by;
  bool operator()(RectangleLight& light) const { return Move(light.corner); }
  bool operator()(DiskLight& light) const { return Move(light.center); }
  bool operator()(SphereLight& light) const { return Move(light.center); }
  bool operator()(PointLight& light) const { return Move(light.position); }
  bool operator()(SpotLight& light) const { return Move(light.position); }
  bool operator()(DistantLight&) const { return false; }
  bool Move(Vec3& place) const {
    place += by;
    return true;
  }
};

struct SetStrength {
  Vec3 rgb;
  void operator()(RectangleLight& light) const { light.radiance = rgb; }
  void operator()(DiskLight& light) const { light.radiance = rgb; }
  void operator()(SphereLight& light) const { light.radiance = rgb; }
  void operator()(PointLight& light) const { light.intensity = rgb; }
  void operator()(SpotLight& light) const { light.intensity = rgb; }
  void operator()(DistantLight& light) const { light.irradiance = rgb; }
};

template <typename T>
void AddIds(const Scene::Table<T>& table, std::vector<std::string>& ids) {
  for (const auto& [id, object] : table) ids.push_back(id);
}

}  // namespace

absl::StatusOr<SceneDelta> MoveObject(const Scene& scene, const std::string& id, Vec3 by) {
  SceneDelta delta;
  if (const auto instance = scene.FindInstance(id)) {
    delta.upsert_instances = {*instance};
    delta.upsert_instances[0].world_from_mesh[3] += by;
  }
  if (const auto light = scene.FindLight(id)) {
    AreaLight moved = *light;
    if (!std::visit(MoveBy{by}, moved.shape)) {
      return FieldError(absl::StatusCode::kInvalidArgument, "NO_PLACE", "id",
                        "found a light that is infinitely far, need one that has a place");
    }
    delta.upsert_lights.push_back(std::move(moved));
  }
  if (!delta.empty()) return delta;
  std::vector<std::string> ids;
  AddIds(scene.instances(), ids);
  AddIds(scene.lights(), ids);
  return UnknownIdError("id", id, std::move(ids));
}

absl::StatusOr<SceneDelta> SetLightStrength(const Scene& scene, const std::string& id, Vec3 rgb) {
  const auto light = scene.FindLight(id);
  if (!light) {
    std::vector<std::string> ids;
    AddIds(scene.lights(), ids);
    return UnknownIdError("id", id, std::move(ids));
  }
  SceneDelta delta;
  delta.upsert_lights = {*light};
  std::visit(SetStrength{rgb}, delta.upsert_lights[0].shape);
  return delta;
}

absl::StatusOr<SceneDelta> RemoveObject(const Scene& scene, const std::string& id) {
  SceneDelta delta;
  if (scene.FindInstance(id)) delta.remove_instances = {id};
  if (scene.FindLight(id)) delta.remove_lights = {id};
  if (scene.FindReceiver(id)) delta.remove_receivers = {id};
  if (!delta.empty()) return delta;
  std::vector<std::string> ids;
  AddIds(scene.instances(), ids);
  AddIds(scene.lights(), ids);
  AddIds(scene.receivers(), ids);
  return UnknownIdError("id", id, std::move(ids));
}

}  // namespace penumbra
