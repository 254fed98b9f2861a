// Adding up one pass's hard shadows: how many samples are hidden from each texel, and what the
// others reflect there.
#pragma once

#include "render/gl/program.h"

namespace penumbra::texture_gl {

inline constexpr int kLightSamplesBinding = 4;  // an Emitter, then the pass's LightSamples
inline constexpr int kShadowsUnit = 1;          // of a pass, a bit each

// Draws 3 vertices over a tile. The colour is to be added to a float target: the number of hidden
// samples, alone or, with `shades`, after the sum of the others' terms times emission and
// reflectance.
//
// Uniforms: slot, rows as in OccluderProgram; with `shades` also size, edge_u, edge_v, normal,
// reflectance, sample_count, two_sided.
gl::ProgramSource ResolveProgram(bool shades);

}  // namespace penumbra::texture_gl
