// Lights that a node carries: KHR_lights_punctual and EXT_lights_area.
//
// Photometric numbers are taken as radiometric ones, as if a lumen were a watt: candela as W·sr⁻¹,
// lux as W·m⁻², nits as W·m⁻²·sr⁻¹. So the lights of a scene keep their ratios, to each other and
// to its glowing surfaces, and no exposure has to make up for 683 lm/W.
#pragma once

#include <string>
#include <vector>

#include "client/import/gltf/transforms.h"
#include "client/import/warnings.h"
#include "render/scene/area_light.h"
#include "tiny_gltf.h"

namespace penumbra::gltf {

// The sun's, in radians: glTF's directional lights have no size, and stand for the sun.
inline constexpr float kSunAngularDiameter = 0.00925f;

struct NodeLight {
  std::string name;  // as in the file; may be empty
  LightShape shape;
};

// The lights of `node`, placed; those of no power or no direction are left out, with a warning.
std::vector<NodeLight> LightsOf(const tinygltf::Model& model, const PlacedNode& node,
                                Warnings& warnings);

}  // namespace penumbra::gltf
