// Parameters of soft_texture.
#pragma once

#include <cstdint>

#include "render/technique/technique_info.h"

namespace penumbra {

struct SoftTextureParams {
  uint32_t samples = 64;  // light samples, 1 to 1,024
  uint64_t seed = 1;      // of the jitter
  bool radiance = false;  // put the radiance texture into the artifact, next to the counts

  friend bool operator==(const SoftTextureParams&, const SoftTextureParams&) = default;

  static constexpr ParameterInfo kParameters[] = {
      {"samples", "uint", "64", "1 to 1024", "light samples; noise falls with their square root"},
      {"seed", "uint", "1", "any 64-bit number",
       "of the jitter: the same seed gives the same bits"},
      {"radiance", "bool", "false", "", "deliver reflected radiance next to the counts"},
  };
  static constexpr TechniqueInfo kInfo = {
      .name = "soft_texture",
      .summary =
          "Soft shadows on a planar patch: at each texel, the exact number of light samples "
          "that see it.",
      .artifact_kind = "soft_shadow_texture",
      .source = "Herf 1997, Efficient Generation of Soft Shadow Textures, CMU-CS-97-138",
      .parameters = kParameters,
  };
};

}  // namespace penumbra
