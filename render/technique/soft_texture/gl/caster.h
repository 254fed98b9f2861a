// An instance as the GL method draws it onto one receiver, and the map of each light sample.
#pragma once

#include <array>
#include <span>
#include <stop_token>
#include <vector>

#include "render/math/vec.h"
#include "render/scene/instance.h"
#include "render/scene/light_sample.h"
#include "render/scene/receiver.h"
#include "render/scene/scene.h"
#include "render/technique/soft_texture/gl/occluder_glsl.h"

namespace penumbra::texture_gl {

struct Caster {
  const Instance* instance = nullptr;
  std::array<DVec3, 8> corners{};  // of its box, from the receiver's origin
  // Least and greatest height over the receiver's front, with room for the vertices' rounding.
  double lowest = 0, highest = 0;
  // +1 or −1: the sign of the projected area of faces towards a light in front. 0: draw all faces.
  int facing = 0;
};

// All instances that cast and have triangles.
std::vector<Caster> CastersOn(const Scene& scene, const ReceiverPatch& receiver);

// Maps of the samples that shadows fall from; the others, in the receiver's plane, hide behind
// nothing, and get a map that draws nothing.
//
// Shapes  n samples → n
std::vector<GpuSampleMap> SampleMaps(const ReceiverPatch& receiver,
                                     std::span<const LightSample> samples, double surface_offset,
                                     const std::stop_token& stop);

// Whether no sample of `maps` casts the caster's shadow onto rows [first_row, first_row + rows).
bool MissesRows(const Caster& caster, std::span<const GpuSampleMap> maps,
                const ReceiverPatch& receiver, uint32_t first_row, uint32_t rows,
                double surface_offset);

// About how many texels of these rows are in the shadow of the caster's box.
double TexelsCovered(const Caster& caster, const GpuSampleMap& map, const ReceiverPatch& receiver,
                     uint32_t first_row, uint32_t rows);

}  // namespace penumbra::texture_gl
