#include "client/cli/light_json.h"

#include <nlohmann/json.hpp>

#include "client/cli/json_number.h"

namespace penumbra {
namespace {

using Json = nlohmann::ordered_json;

Json ToJson(Vec3 v) { return {JsonNumber(v.x), JsonNumber(v.y), JsonNumber(v.z)}; }

Json ToJson(const RectangleLight& light) {
  return {{"type", "rectangle"},
          {"corner", ToJson(light.corner)},
          {"edge_u", ToJson(light.edge_u)},
          {"edge_v", ToJson(light.edge_v)},
          {"radiance", ToJson(light.radiance)},
          {"two_sided", light.two_sided}};
}

Json ToJson(const DiskLight& light) {
  return {{"type", "disk"},
          {"center", ToJson(light.center)},
          {"normal", ToJson(light.normal)},
          {"radius", JsonNumber(light.radius)},
          {"radiance", ToJson(light.radiance)},
          {"two_sided", light.two_sided}};
}

Json ToJson(const SphereLight& light) {
  return {{"type", "sphere"},
          {"center", ToJson(light.center)},
          {"radius", JsonNumber(light.radius)},
          {"radiance", ToJson(light.radiance)}};
}

Json ToJson(const PointLight& light) {
  return {{"type", "point"},
          {"position", ToJson(light.position)},
          {"intensity", ToJson(light.intensity)}};
}

Json ToJson(const SpotLight& light) {
  return {{"type", "spot"},
          {"position", ToJson(light.position)},
          {"direction", ToJson(light.direction)},
          {"intensity", ToJson(light.intensity)},
          {"inner_angle", JsonNumber(light.inner_angle)},
          {"outer_angle", JsonNumber(light.outer_angle)}};
}

Json ToJson(const DistantLight& light) {
  return {{"type", "distant"},
          {"to_light", ToJson(light.to_light)},
          {"angular_diameter", JsonNumber(light.angular_diameter)},
          {"irradiance", ToJson(light.irradiance)}};
}

}  // namespace

nlohmann::ordered_json LightToJson(const AreaLight& light) {
  Json json = {{"id", light.id}};
  json.update(std::visit([](const auto& shape) { return ToJson(shape); }, light.shape));
  return json;
}

}  // namespace penumbra
