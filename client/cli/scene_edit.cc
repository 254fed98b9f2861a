#include "client/cli/scene_edit.h"

#include <algorithm>
#include <utility>
#include <variant>

namespace penumbra {
namespace {

// A box this much of the scene's, in any of its dimensions, is a room or a ground.
constexpr float kMostOfScene = 0.9f;

float Volume(Vec3 extent) { return extent.x * extent.y * extent.z; }

void Move(RectangleLight& light, Vec3 by) { light.corner += by; }
void Move(DiskLight& light, Vec3 by) { light.center += by; }
void Move(SphereLight& light, Vec3 by) { light.center += by; }
void Move(PointLight& light, Vec3 by) { light.position += by; }
void Move(SpotLight& light, Vec3 by) { light.position += by; }
void Move(DistantLight& light, Vec3 by) {
  constexpr float kTurn = 0.3f;  // about 17 degrees
  light.to_light = glm::normalize(light.to_light) + kTurn * glm::normalize(by);
}

struct Emission {
  Vec3 operator()(const RectangleLight& light) const { return light.radiance; }
  Vec3 operator()(const DiskLight& light) const { return light.radiance; }
  Vec3 operator()(const SphereLight& light) const { return light.radiance; }
  Vec3 operator()(const PointLight& light) const { return light.intensity; }
  Vec3 operator()(const SpotLight& light) const { return light.intensity; }
  Vec3 operator()(const DistantLight& light) const { return light.irradiance; }
};

// Roughly how much light it sends out; enough to tell a softbox from a candle.
float Brightness(const AreaLight& light) {
  const Vec3 emission = std::visit(Emission{}, light.shape);
  const float area = LightArea(light);
  return (emission.x + emission.y + emission.z) * (area > 0 ? area : 1.0f);
}

}  // namespace

absl::StatusOr<SceneDelta> MoveAnObject(const Scene& scene) {
  const Vec3 whole = scene.Bounds().extent();
  std::shared_ptr<const Instance> chosen;
  std::pair<bool, float> best;
  for (const auto& [id, instance] : scene.instances()) {
    const Vec3 extent = WorldBounds(*instance).extent();
    if (!instance->casts || extent == Vec3(0.0f)) continue;
    const bool is_object = Volume(extent) > 0.0f && extent.x < kMostOfScene * whole.x &&
                           extent.z < kMostOfScene * whole.z;
    const std::pair<bool, float> rank(is_object, Volume(extent));
    if (chosen == nullptr || rank > best) {
      chosen = instance;
      best = rank;
    }
  }
  if (chosen == nullptr) {
    return absl::FailedPreconditionError("scene: found nothing that casts, need an object to move");
  }
  Instance moved = *chosen;
  const Vec3 extent = WorldBounds(moved).extent();
  moved.world_from_mesh[3].x += std::max({extent.x, extent.y, extent.z}) / 3.0f;
  SceneDelta delta;
  delta.upsert_instances.push_back(std::move(moved));
  return delta;
}

absl::StatusOr<SceneDelta> MoveTheLamp(const Scene& scene) {
  if (scene.lights().empty()) {
    return absl::FailedPreconditionError("scene: found no light, need one to move");
  }
  const auto brighter = [](const auto& a, const auto& b) {
    return Brightness(*a.second) < Brightness(*b.second);
  };
  const auto& lights = scene.lights();
  AreaLight light = *std::max_element(lights.begin(), lights.end(), brighter)->second;
  const Vec3 extent = scene.Bounds().extent();
  const float distance = std::max({extent.x, extent.z, 1e-3f}) / 5.0f;
  const Vec3 by(distance, 0, -distance);
  std::visit([&](auto& shape) { Move(shape, by); }, light.shape);
  SceneDelta delta;
  // An importer calls a light as the glowing instance that it stands for.
  if (const auto glowing = scene.FindInstance(light.id)) {
    delta.upsert_instances = {*glowing};
    delta.upsert_instances[0].world_from_mesh[3] += by;
  }
  delta.upsert_lights.push_back(std::move(light));
  return delta;
}

}  // namespace penumbra
