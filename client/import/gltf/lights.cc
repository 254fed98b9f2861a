#include "client/import/gltf/lights.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "absl/strings/str_cat.h"
#include "client/import/gltf/document.h"

namespace penumbra::gltf {
namespace {

// The node's axes in the world; lights shine along −z.
struct Frame {
  Vec3 origin{0.0f};
  Vec3 x{1, 0, 0};
  Vec3 y{0, 1, 0};
  Vec3 z{0, 0, 1};
  float scale = 1.0f;  // the largest of the three axes' lengths
};

std::optional<Frame> FrameOf(const DMat4& world_from_node) {
  const DVec3 z(world_from_node[2]);
  const DVec3 y(world_from_node[1]);
  const double scale =
      std::max({glm::length(DVec3(world_from_node[0])), glm::length(y), glm::length(z)});
  if (!(glm::length(z) > 0.0) || !std::isfinite(scale)) return std::nullopt;
  // A sheared or flattened node still has a direction; the other axes are made to fit it.
  const DVec3 unit_z = glm::normalize(z);
  DVec3 up = y - glm::dot(y, unit_z) * unit_z;
  if (!(glm::length(up) > 1e-9 * scale)) {
    up = std::abs(unit_z.y) < 0.9 ? DVec3(0, 1, 0) : DVec3(1, 0, 0);
    up -= glm::dot(up, unit_z) * unit_z;
  }
  up = glm::normalize(up);
  return Frame{.origin = Vec3(DVec3(world_from_node[3])),
               .x = Vec3(glm::cross(up, unit_z)),
               .y = Vec3(up),
               .z = Vec3(unit_z),
               .scale = static_cast<float>(scale)};
}

std::optional<LightShape> Punctual(const tinygltf::Light& light, const Frame& frame) {
  Vec3 power(static_cast<float>(light.intensity));
  if (light.color.size() == 3) power *= Vec3(DVec3(light.color[0], light.color[1], light.color[2]));
  if (!IsFinite(power) || power == Vec3(0.0f) || glm::any(glm::lessThan(power, Vec3(0.0f)))) {
    return std::nullopt;
  }
  if (light.type == "directional") {
    return DistantLight{
        .to_light = frame.z, .angular_diameter = kSunAngularDiameter, .irradiance = power};
  }
  if (light.type == "point") return PointLight{.position = frame.origin, .intensity = power};
  const float outer = std::clamp(static_cast<float>(light.spot.outerConeAngle), 1e-4f,
                                 std::numbers::pi_v<float> / 2);
  return SpotLight{.position = frame.origin,
                   .direction = -frame.z,
                   .intensity = power,
                   .inner_angle = std::clamp(static_cast<float>(light.spot.innerConeAngle), 0.0f,
                                             outer * (1.0f - 1e-5f)),
                   .outer_angle = outer};
}

// Source  EXT_lights_area, draft of 2025
std::optional<LightShape> Area(const tinygltf::Value& light, const Frame& frame) {
  Vec3 radiance(static_cast<float>(NumberOr(light, "intensity", 1000.0)));
  if (light.Has("color")) {
    const tinygltf::Value& color = light.Get("color");
    radiance *= Vec3(DVec3(color.Get(0).GetNumberAsDouble(), color.Get(1).GetNumberAsDouble(),
                           color.Get(2).GetNumberAsDouble()));
  }
  const float height = frame.scale * static_cast<float>(NumberOr(light, "size", 1.0));
  const float aspect =
      light.Has("rect") ? static_cast<float>(NumberOr(light.Get("rect"), "aspect", 1.0)) : 1.0f;
  if (!IsFinite(radiance) || glm::any(glm::lessThan(radiance, Vec3(0.0f))) ||
      !(height > 0.0f && std::isfinite(height * aspect) && aspect > 0.0f)) {
    return std::nullopt;
  }
  if (light.Get("type").Get<std::string>() == "disk") {
    return DiskLight{.center = frame.origin,
                     .normal = -frame.z,
                     .radius = 0.5f * height,
                     .radiance = radiance,
                     .two_sided = false};
  }
  const Vec3 edge_u = height * aspect * frame.x;
  const Vec3 edge_v = -height * frame.y;  // x × −y = −z, the front
  return RectangleLight{.corner = frame.origin - 0.5f * edge_u - 0.5f * edge_v,
                        .edge_u = edge_u,
                        .edge_v = edge_v,
                        .radiance = radiance,
                        .two_sided = false};
}

}  // namespace

std::vector<NodeLight> LightsOf(const tinygltf::Model& model, const PlacedNode& node,
                                Warnings& warnings) {
  std::vector<NodeLight> lights;
  const tinygltf::ExtensionMap& extensions = model.nodes[node.node].extensions;
  const auto* punctual = FindExtension(extensions, "KHR_lights_punctual");
  const auto* area = FindExtension(extensions, "EXT_lights_area");
  const std::optional<Frame> frame = FrameOf(node.world_from_node);
  const auto add = [&](const std::string& name, std::optional<LightShape> shape) {
    if (shape) {
      lights.push_back({name, *shape});
    } else {
      warnings.Add(absl::StrCat("nodes[", node.node, "]: its light has no power, no size or no ",
                                "direction, ignored"));
    }
  };
  if (punctual && punctual->Has("light")) {
    const size_t index = static_cast<size_t>(NumberOr(*punctual, "light", 0));
    if (index < model.lights.size()) {
      const tinygltf::Light& light = model.lights[index];
      add(light.name, frame ? Punctual(light, *frame) : std::nullopt);
    }
  }
  if (area && area->Has("light")) {
    const tinygltf::Value& light = FindExtension(model.extensions, "EXT_lights_area")
                                       ->Get("lights")
                                       .Get(static_cast<int>(NumberOr(*area, "light", 0)));
    const std::string name = light.Has("name") ? light.Get("name").Get<std::string>() : "";
    add(name, frame ? Area(light, *frame) : std::nullopt);
  }
  return lights;
}

}  // namespace penumbra::gltf
