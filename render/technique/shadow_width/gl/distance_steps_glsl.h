// The programs that take distances step by step.
#pragma once

#include "render/gl/program.h"

namespace penumbra::width_gl {

inline constexpr int kSourceUnit = 0;  // of the texture that a pass reads

// The distance of texels that no way leads from. A float that steps added to it leave as it is.
inline constexpr float kNowhere = 0x1p100f;

// Draws 3 vertices over a float target: 0 where the texel of an unsigned texture is 0, else kNowhere.
gl::ProgramSource StartProgram();

// Draws 3 vertices over a float target: the least of the texel's distance and of its neighbours' and
// the way to them. Uniforms: offsets[i] (ivec2) and lengths[i] (float) for i < neighbours.
gl::ProgramSource StepProgram(int neighbours);

}  // namespace penumbra::width_gl
