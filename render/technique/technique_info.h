// What a technique says of itself.
#pragma once

#include <span>
#include <string_view>

namespace penumbra {

struct ParameterInfo {
  std::string_view name;
  std::string_view type;  // "uint", "bool", "float", "enum", "rgb"
  std::string_view default_value;
  std::string_view range;
  std::string_view meaning;
};

struct TechniqueInfo {
  std::string_view name;           // "soft_texture"
  std::string_view summary;        // one sentence
  std::string_view artifact_kind;  // "soft_shadow_texture"
  std::string_view source;         // the paper
  std::span<const ParameterInfo> parameters;
};

}  // namespace penumbra
