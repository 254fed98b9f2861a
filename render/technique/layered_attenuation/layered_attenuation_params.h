// Parameters of layered_attenuation.
#pragma once

#include <cstdint>

#include "render/light_view/depth_method.h"
#include "render/technique/technique_info.h"

namespace penumbra {

// An image's longer side: up to far above a screen's.
inline constexpr uint32_t kMinLdiResolution = 8;
inline constexpr uint32_t kMaxLdiResolution = 8'192;
// In pixels' widths. More would join surfaces that are far apart.
inline constexpr float kMaxLdiTolerance = 16.0f;
// What a tile that is sent has room for.
inline constexpr uint32_t kMaxLdiLayers = 128;

struct LayeredAttenuationParams {
  uint32_t samples = 64;      // light samples, 1 to 1,024
  uint64_t seed = 1;          // of the jitter
  uint32_t resolution = 512;  // pixels along the longer side of each face's image
  float tolerance = 0.0f;     // how far from a layer its surface may be, pixels' widths; 0: 1
  DepthMethod source = DepthMethod::kAuto;  // what draws depth maps
  bool key_views = false;    // draw from the light's corners and middle alone, and warp the rest
  uint32_t max_layers = 64;  // a pixel; more are refused

  friend bool operator==(const LayeredAttenuationParams&,
                         const LayeredAttenuationParams&) = default;

  static constexpr ParameterInfo kParameters[] = {
      {"samples", "uint", "64", "1 to 1024", "light samples; noise falls with their square root"},
      {"seed", "uint", "1", "any 64-bit number",
       "of the jitter: the same seed gives the same bits"},
      {"resolution", "uint", "512", "8 to 8192",
       "pixels along the longer side of each face's image"},
      {"tolerance", "float", "0", "0 to 16",
       "how far from a layer its surface may be, in pixels' widths; 0: 1"},
      {"source", "enum", "auto", "auto, raster, rays or gl",
       "what draws depth maps; auto: raster, rays or both, whichever costs least for a view"},
      {"key_views", "bool", "false", "",
       "draw from the light's corners and middle alone and warp the other views from these"},
      {"max_layers", "uint", "64", "1 to 128", "layers that a pixel may have; more are refused"},
  };
  static constexpr TechniqueInfo kInfo = {
      .name = "layered_attenuation",
      .summary =
          "The preview while things move: soft shadows on all surfaces at once, for any view, as "
          "layers of all that a light sees, with how much of it each is seen by.",
      .artifact_kind = "attenuation_ldi",
      .target = SpecTarget::kScene,
      .source =
          "Agrawala, Ramamoorthi, Heirich and Moll 2000, Efficient Image-Based Methods for "
          "Rendering Soft Shadows, SIGGRAPH",
      .parameters = kParameters,
  };
};

}  // namespace penumbra
