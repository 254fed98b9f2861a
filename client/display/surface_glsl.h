// The shaders of the thin renderer: what faces look like, and what glows.
#pragma once

#include <string>

#include "client/display/shadow_words_glsl.h"
#include "render/gl/program.h"

namespace penumbra {

// Storage blocks of the surface program.
inline constexpr int kLightsBinding = 0;
inline constexpr int kReceiversBinding = 1;
inline constexpr int kCountsBinding = 2;
inline constexpr int kCandidatesBinding = 3;
inline constexpr int kFaceNormalsBinding = 4;
inline constexpr int kLightShadowsBinding = 5;
inline constexpr int kLightFacesBinding = 6;
inline constexpr int kWordsBinding = 7;
inline constexpr ShadowWordBindings kShadowWordBindings = {
    .shadows = kLightShadowsBinding, .faces = kLightFacesBinding, .words = kWordsBinding};
// Texture unit of the alpha mask.
inline constexpr int kMaskUnit = 0;

// Set in a candidate's receiver index when the surface is the receiver, whatever its place says.
inline constexpr uint32_t kIsTheReceiver = 0x80000000u;
// Set when the receiver is one of the surface's own faces: then a point on it that no texel's centre
// comes near, in the tip of a sharp corner, is the receiver's all the same.
inline constexpr uint32_t kIsPartOfIt = 0x40000000u;

gl::ProgramSource SurfaceProgram();
// The same with another way to find shadows by place: GLSL that declares what ShadowWordsGlsl() does.
gl::ProgramSource SurfaceProgram(const std::string& shadow_words_glsl);
gl::ProgramSource GlowProgram();

}  // namespace penumbra
