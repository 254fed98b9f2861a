// The closed forms of render/math/form_factor.h and render/scene/unoccluded_light.h once more, in
// GLSL and single precision, and how lights are handed to them.
//
// The two are compared by tests/gl/display. Where the C++ may subtract nearly equal numbers in
// double precision, the GLSL is arranged so that it does not subtract them: edges are passed as
// they are instead of as differences of corners, and small angles by series.
#pragma once

#include <string>

#include "render/math/vec.h"
#include "render/scene/area_light.h"

namespace penumbra {

// One light as a shader sees it, std430. `emission.w` is the kind, in the order of LightShape.
struct GpuLight {
  Vec4 a{0};         // corner, center, position or to_light; w: 1 if two-sided
  Vec4 b{0};         // edge_u, axis or direction; w: radius, or sin α of a disc in the sky
  Vec4 c{0};         // edge_v; or cos_outer and cos_inner
  Vec4 emission{0};  // radiance, intensity or irradiance
};

GpuLight ToGpu(const AreaLight& light);

// GLSL that declares `struct Light` and
//
//   float FormFactorOfPolygon4(vec3 r0, vec3 edge_u, vec3 edge_v, vec3 n)   r0: from the point
//   float FormFactorOfDisk(vec3 to_center, vec3 axis, float radius, vec3 n)
//   float FormFactorOfCap(float cos_to_axis, float sin2_alpha)
//   vec3 UnoccludedRadiance(Light light, vec3 point, vec3 n)
//
// together with the constants that it needs.
std::string FormFactorGlsl();

}  // namespace penumbra
