// What a technique says of itself.
#pragma once

#include <cstdint>
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

// What a technique computes for.
enum class SpecTarget : uint8_t {
  kReceiver,  // a receiver of the scene, that lies in a plane
  kScene,     // all surfaces at once
  kPoints,    // points on surfaces (render/scene/point_receiver.h)
};

struct TechniqueInfo {
  std::string_view name;           // "soft_texture"
  std::string_view summary;        // one sentence
  std::string_view artifact_kind;  // "soft_shadow_texture"
  SpecTarget target = SpecTarget::kReceiver;
  // Its shadows look right, but no parameter makes them those of the light.
  bool is_plausible = false;
  std::string_view source;  // the paper
  std::span<const ParameterInfo> parameters;
};

}  // namespace penumbra
