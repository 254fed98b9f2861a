// LightAbovePlane() of render/artifact/light_above_plane.h in GLSL and single precision.
#pragma once

#include <string>

namespace penumbra {

// GLSL that declares, after FormFactorGlsl(),
//
//   float LightAbovePlane(Light light, vec3 point, vec3 n)
std::string LightAbovePlaneGlsl();

}  // namespace penumbra
