// Direct light with something in the way, by brute force in double precision: the oracle for the
// radiance of soft_texture.
//
//   const auto points = LightQuadrature(light, 64);
//   DVec3 radiance = DirectRadiance(light, points, texel, normal, visible);
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/math/vec.h"
#include "render/scene/area_light.h"
#include "render/scene/light_sample.h"

namespace penumbra {

// A point of a light, or a direction of a distant one.
struct QuadraturePoint {
  LightSample sample;
  DVec3 facing{0.0};  // unit normal of the surface that emits; of a distant light, unused
  double measure;     // m²; of a distant light sr
};

// About per_side² points, evenly spread: over a rectangle's edges, over a disk by rings of equal
// area, over the whole of a sphere by bands of equal height, over the cone of a distant light by
// bands of equal solid angle. A light without size has one point.
std::vector<QuadraturePoint> LightQuadrature(const AreaLight& light, uint32_t per_side);

// The samples that SampleLight made of `light` for a patch with its middle at `target`, with the
// measure that each stands for: the inverse of the density they were made with, over their number.
std::vector<QuadraturePoint> MeasuredSamples(const AreaLight& light,
                                             std::span<const LightSample> samples, DVec3 target);

// Radiance that a white diffuse surface at `point` reflects:
//
//   L = 1/π Σ_i max(0, n · d_i) L_i v_i dω_i,   dω_i = dA_i cos θ'_i / r_i²
//
// visible  one flag a point; empty: all are
DVec3 DirectRadiance(const AreaLight& light, std::span<const QuadraturePoint> points, DVec3 point,
                     DVec3 normal, std::span<const uint8_t> visible);

}  // namespace penumbra
