// The lights of a scene. Radiance in W·m⁻²·sr⁻¹, intensity in W·sr⁻¹, irradiance in W·m⁻², each
// linear RGB and ≥ 0.
#pragma once

#include <string>
#include <variant>

#include "render/math/vec.h"

namespace penumbra {

// corner + s·edge_u + t·edge_v for s, t in [0, 1]. The front is edge_u × edge_v.
struct RectangleLight {
  Vec3 corner{0.0f};
  Vec3 edge_u{1, 0, 0};
  Vec3 edge_v{0, 0, 1};
  Vec3 radiance{1.0f};
  bool two_sided = true;  // shines from both faces; otherwise from the front alone
};

struct DiskLight {
  Vec3 center{0.0f};
  Vec3 normal{0, -1, 0};  // any length > 0
  float radius = 0.5f;    // > 0
  Vec3 radiance{1.0f};
  bool two_sided = true;
};

struct SphereLight {
  Vec3 center{0.0f};
  float radius = 0.5f;  // > 0
  Vec3 radiance{1.0f};
};

struct PointLight {
  Vec3 position{0.0f};
  Vec3 intensity{1.0f};
};

// A point light in a cone: full inside `inner_angle` of the axis, none outside `outer_angle`.
struct SpotLight {
  Vec3 position{0.0f};
  Vec3 direction{0, -1, 0};  // where it shines to; any length > 0
  Vec3 intensity{1.0f};      // on the axis
  float inner_angle = 0.0f;  // radians, half the cone's opening; 0 ≤ inner < outer ≤ π/2
  float outer_angle = 0.785398163f;
};

// Light from infinitely far, a disc of `angular_diameter` in the sky (the sun: 0.00925).
struct DistantLight {
  Vec3 to_light{0, 1, 0};         // towards the disc's centre; any length > 0
  float angular_diameter = 0.0f;  // radians, [0, π/2]; 0 casts hard shadows
  Vec3 irradiance{1.0f};          // on a surface that faces the light
};

using LightShape =
    std::variant<RectangleLight, DiskLight, SphereLight, PointLight, SpotLight, DistantLight>;

struct AreaLight {
  std::string id;  // as for instances; unique among a scene's lights
  LightShape shape;

  friend bool operator==(const AreaLight&, const AreaLight&);
};

// The area of a rectangle, disk or sphere, in m²; 0 for lights that have none.
float LightArea(const AreaLight& light);

}  // namespace penumbra
