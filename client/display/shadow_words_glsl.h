// How much of a light a surface sees by its layered attenuation map, its shadow-width map, or by a
// picture, in GLSL.
#pragma once

#include <string>

namespace penumbra {

// Where the storage blocks of ShadowWords are.
struct ShadowWordBindings {
  int shadows;  // LightShadow, one a light
  int faces;    // GpuLightFace
  int words;
};

// GLSL that declares, with lights by their index,
//
//   int DrawnLight(int place)                              the light that is drawn in that place
//   bool HasLayers(int light)
//   float LayerVisibility(int light, vec3 point, vec3 n)   by the layers alone: at most
//                                                          LightAbovePlane() of it can be right
//   bool HasWidths(int light)
//   float WidthVisibility(int light, vec3 point, vec3 n)   by the shadow-width map alone, likewise
//   bool FindInPicture(int light, vec3 at_center, vec3 inside, out float value)
//   bool HasShares(int light)                              whether that value is of the light seen,
//                                                          or of its strength reflected
std::string ShadowWordsGlsl(const ShadowWordBindings& bindings);
// Its structures and storage blocks alone.
std::string ShadowWordBlocksGlsl(const ShadowWordBindings& bindings);

}  // namespace penumbra
