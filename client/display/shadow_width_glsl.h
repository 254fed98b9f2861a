// Visibility() by shadow-width maps, in GLSL.
#pragma once

#include <string>

namespace penumbra {

// A part of ShadowWordsGlsl(), after what it declares of faces.
std::string ShadowWidthGlsl();

}  // namespace penumbra
