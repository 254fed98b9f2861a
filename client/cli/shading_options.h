// The options about what an artifact holds besides counts, in how many bits, and how exactly.
//
//   for (const ShadingOption& option : ShadingOptions()) …  // option.set(params, text)
#pragma once

#include <span>
#include <string_view>

#include "absl/status/status.h"
#include "render/technique/technique_params.h"

namespace penumbra {

struct ShadingOption {
  const char* name;  // "--shading"
  const char* form;  // of its value
  const char* help;
  // Errors  kInvalidArgument, with the option as the field path
  absl::Status (*set)(TechniqueParams& params, std::string_view text);
};

// Those about radiance ask for it too.
std::span<const ShadingOption> ShadingOptions();

}  // namespace penumbra
