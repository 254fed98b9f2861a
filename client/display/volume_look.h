// What is made of the shadows that shadow volumes tell of.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace penumbra {

enum class VolumeShading : uint8_t {
  kAmbient,     // each light is added where it is seen: right, and surfaces are drawn once a light
  kComposited,  // what is in shadow is darkened, other lights' share and highlights with it
  kBlack,       // the same, all the way
};

// In the order of the shadings.
inline constexpr std::array<std::string_view, 3> kVolumeShadingNames = {"ambient", "composited",
                                                                        "black"};

inline constexpr int kMaxVolumePasses = 64;

struct VolumeLook {
  VolumeShading shading = VolumeShading::kAmbient;
  float opacity = 0.5f;  // of composited shadows, 0 to 1
  int passes = 1;        // 1 to 64; several, each a little turned, smooth the edges
};

}  // namespace penumbra
