// Parameters of soft_texture.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "render/technique/technique_info.h"

namespace penumbra {

// How the hard shadow of one light sample is drawn. All give the same counts.
enum class VisibilityMethod : uint8_t {
  kAuto,        // whichever is quickest for each occluder
  kCoverage,    // every triangle is filled
  kEdgeFlag,    // every triangle's edges are flagged, and rows summed up
  kSilhouette,  // the same with the edges of meshes' outlines alone
  kGl,  // drawn by OpenGL, and radiance by the sum over samples; needs an engine that has it
};

// In the order of the methods.
inline constexpr std::array<std::string_view, 5> kVisibilityMethodNames = {
    "auto", "coverage", "edge_flag", "silhouette", "gl"};

constexpr std::string_view NameOf(VisibilityMethod method) {
  return kVisibilityMethodNames[static_cast<size_t>(method)];
}

inline std::optional<VisibilityMethod> VisibilityMethodNamed(std::string_view name) {
  for (size_t i = 0; i < kVisibilityMethodNames.size(); ++i) {
    if (kVisibilityMethodNames[i] == name) return static_cast<VisibilityMethod>(i);
  }
  return std::nullopt;
}

struct SoftTextureParams {
  uint32_t samples = 64;  // light samples, 1 to 1,024
  uint64_t seed = 1;      // of the jitter
  bool radiance = false;  // put the radiance texture into the artifact, next to the counts

  VisibilityMethod method = VisibilityMethod::kAuto;  // makes no difference but of time

  friend bool operator==(const SoftTextureParams&, const SoftTextureParams&) = default;

  static constexpr ParameterInfo kParameters[] = {
      {"samples", "uint", "64", "1 to 1024", "light samples; noise falls with their square root"},
      {"seed", "uint", "1", "any 64-bit number",
       "of the jitter: the same seed gives the same bits"},
      {"radiance", "bool", "false", "", "deliver reflected radiance next to the counts"},
      {"method", "enum", "auto", "auto, coverage, edge_flag, silhouette or gl",
       "how hard shadows are drawn; all give the same counts"},
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
