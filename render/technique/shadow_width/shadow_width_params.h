// Parameters of shadow_width.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "render/light_view/depth_method.h"
#include "render/technique/technique_info.h"

namespace penumbra {

// A map's longer side: up to far above a screen's.
inline constexpr uint32_t kMinWidthResolution = 1;
inline constexpr uint32_t kMaxWidthResolution = 8'192;
// More than hides every penumbra, and less than single precision loses.
inline constexpr float kMaxCScale = 1e6f;
// As much as all of a penumbra.
inline constexpr float kMaxCBias = 1.0f;
inline constexpr uint32_t kMaxWidthLayers = 2;
// Of all faces together: a gigabyte while they are kept. As many as a client takes.
inline constexpr uint64_t kMaxWidthTexels = uint64_t{1} << 26;

// How distances to what is lit are found.
enum class DistanceMethod : uint8_t {
  kExact,    // Euclidean, by the CPU
  kSweep,    // the paper's, texel by texel from neighbours, by the CPU
  kGlThree,  // the paper's, in doubling steps from three neighbours, by GL
  kGlSix,    // from six
};

// In the order of the methods.
inline constexpr std::array<std::string_view, 4> kDistanceMethodNames = {"exact", "sweep", "gl3",
                                                                         "gl6"};

constexpr std::string_view NameOf(DistanceMethod method) {
  return kDistanceMethodNames[static_cast<size_t>(method)];
}

// Which surface of what blocks the light a depth map has.
enum class BlockerDepth : uint8_t {
  kNearest,   // the one that the light sees
  kFarthest,  // the last one before the receiver: shadows are sharp where the two touch
};

inline constexpr std::array<std::string_view, 2> kBlockerDepthNames = {"nearest", "farthest"};

constexpr std::string_view NameOf(BlockerDepth depth) {
  return kBlockerDepthNames[static_cast<size_t>(depth)];
}

struct ShadowWidthParams {
  uint32_t resolution = 512;  // texels along the longer side of each face's map
  DistanceMethod distance = DistanceMethod::kExact;
  uint32_t layers = 2;  // 1: one width a texel, as in the paper; 2: receivers above others apart
  BlockerDepth blocker_depth = BlockerDepth::kFarthest;
  float c_scale = 0.0f;  // of the attenuation; 0: by the light's size
  float c_bias = 0.0f;
  DepthMethod source = DepthMethod::kAuto;  // what draws the depth maps

  friend bool operator==(const ShadowWidthParams&, const ShadowWidthParams&) = default;

  static constexpr ParameterInfo kParameters[] = {
      {"resolution", "uint", "512", "1 to 8192", "texels along the longer side of each face's map"},
      {"distance", "enum", "exact", "exact, sweep, gl3 or gl6",
       "how distances to what is lit are found; all but exact are approximations"},
      {"layers", "uint", "2", "1 or 2",
       "2: surfaces that lie above others have widths of their own; 1: the paper's"},
      {"blocker_depth", "enum", "farthest", "nearest or farthest",
       "which surface of what blocks the light counts: the one it sees, or the last before the "
       "receiver"},
      {"c_scale", "float", "0", "0 to 1000000",
       "how narrow penumbras are; 0: as wide as the light's"},
      {"c_bias", "float", "0", "0 to 1", "the part of a penumbra that is lit besides"},
      {"source", "enum", "auto", "auto, raster, rays or gl",
       "what draws depth maps; auto: raster, rays or both, whichever costs least for a view"},
  };
  static constexpr TechniqueInfo kInfo = {
      .name = "shadow_width",
      .summary =
          "The quickest soft shadows, on all surfaces and for any view: plausible penumbras from a "
          "single light sample, as a depth map with the distance of each texel to the light.",
      .artifact_kind = "shadow_width_map",
      .target = SpecTarget::kScene,
      .is_plausible = true,
      .source =
          "Kirsch and Döllner 2003, Real-Time Soft Shadows Using a Single Light Sample, Journal of "
          "WSCG 11",
      .parameters = kParameters,
  };
};

}  // namespace penumbra
