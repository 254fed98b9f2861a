// One light sample's term of the sum over samples, equation (3.2): what it adds to the radiance of
// a texel that sees it. In C++ in double precision, and in GLSL.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "render/math/vec.h"
#include "render/scene/area_light.h"
#include "render/scene/light_sample.h"
#include "render/scene/receiver.h"

namespace penumbra::texture_gl {

// How a light's samples shed light.
enum class Emitter : int32_t { kSurface = 0, kPoint = 1, kSky = 2 };

// A sample as shaders see it, std140; places and directions from the receiver's origin.
struct GpuLightSample {
  // Place, or direction of length 1 for the sky. w: the area in m² that it stands for (surface), or
  // the factor by which it differs from an equal share (sky).
  Vec4 place{0};
  Vec4 normal{0};  // of the surface, or a spot's axis; length 1
};

// What all samples of a light have in common, std140.
struct GpuEmitter {
  Vec4 emission{0};  // radiance, intensity or irradiance
  // x: the Emitter; y: 1 if both faces of the surface shine; z and w: cosines of a spot's outer and
  // inner angle, −2 where there is no cone.
  Vec4 kind{0};
};

GpuEmitter EmitterOf(const AreaLight& light);

// Areas are those of n equal shares of the light, times n: the sum of n terms is n times the
// radiance. A sphere's samples lie on the half that faces `target`, evenly over the disc seen from
// there, so that each stands for more area the more it is turned away.
//
// Shapes  n samples → n
std::vector<GpuLightSample> LightSamplesForGpu(const AreaLight& light,
                                               std::span<const LightSample> samples,
                                               const Parallelogram& patch);

// The term, for emission 1 and reflectance 1, at `point` (from the receiver's origin):
//
//   a cos θ cos θ' / (π r²)  (surface),   f cos θ / (π r²)  (point, f the cone's share),
//   a cos θ / π  (sky)
//
// cos θ counts on the front of the receiver only unless it is `two_sided`, cos θ' likewise.
//
// Units   1 (surface, sky), m⁻² (point)
// Source  Herf 1997, equation 3.2
double SampleTerm(const GpuLightSample& sample, const GpuEmitter& emitter, DVec3 point,
                  DVec3 normal, bool two_sided);

// GLSL that declares `struct LightSample { vec4 place, normal; }`, `struct Emitter { vec4 emission,
// kind; }` and
//
//   float SampleTerm(LightSample s, Emitter emitter, vec3 point, vec3 normal, bool two_sided)
std::string SampleTermGlsl();

}  // namespace penumbra::texture_gl
