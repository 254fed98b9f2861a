// The one list of techniques. A new alternative here does not compile until the factory
// (technique_factory.cc) and the converters (proto/convert) know it; the command line,
// ListTechniques, the conformance tests, the benchmarks and the docs iterate over it.
#pragma once

#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "render/technique/coherent_raytrace/coherent_raytrace_params.h"
#include "render/technique/layered_attenuation/layered_attenuation_params.h"
#include "render/technique/shadow_volume/shadow_volume_params.h"
#include "render/technique/shadow_width/shadow_width_params.h"
#include "render/technique/soft_texture/soft_texture_params.h"
#include "render/technique/technique_info.h"

namespace penumbra {

using TechniqueParams = std::variant<SoftTextureParams, LayeredAttenuationParams,
                                     CoherentRaytraceParams, ShadowWidthParams, ShadowVolumeParams>;

inline const TechniqueInfo& InfoOf(const TechniqueParams& params) {
  return std::visit(
      [](const auto& p) -> const TechniqueInfo& { return std::decay_t<decltype(p)>::kInfo; },
      params);
}

// Each technique's parameters at their defaults, in the order of the list.
inline std::vector<TechniqueParams> AllTechniques() {
  std::vector<TechniqueParams> all;
  [&]<size_t... I>(std::index_sequence<I...>) {
    (all.emplace_back(std::variant_alternative_t<I, TechniqueParams>{}), ...);
  }
  (std::make_index_sequence<std::variant_size_v<TechniqueParams>>{});
  return all;
}

}  // namespace penumbra
