// Parameters of soft_texture.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "render/artifact/radiance_format.h"
#include "render/math/vec.h"
#include "render/technique/technique_info.h"

namespace penumbra {

// How the hard shadow of one light sample is drawn. All give the same counts, unless outlines are
// borrowed (silhouette_reuse).
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

// With more, an outline would be borrowed from far across the light.
inline constexpr uint32_t kMaxSilhouetteReuse = 64;

// How what reaches a texel is weighed, where radiance is asked for.
enum class Shading : uint8_t {
  kProduct,    // visible fraction times the unoccluded radiance in closed form, equation 4.1
  kSampleSum,  // what each visible sample sends, added up, equation 3.2
};

inline constexpr std::array<std::string_view, 2> kShadingNames = {"product", "sample_sum"};

// Beyond this relative error an interpolated form factor would show.
inline constexpr float kMaxFormFactorError = 0.1f;
// Far from where single precision ends.
inline constexpr float kMaxOutputScale = 1e30f;

// Bits a count.
enum class CountBits : uint8_t {
  kAuto,  // 8 where the number of samples allows
  k8,
  k16,
};

inline constexpr std::array<std::string_view, 3> kCountBitsNames = {"auto", "8", "16"};

// 0 for kAuto.
constexpr uint32_t BitsOf(CountBits bits) { return 8 * static_cast<uint32_t>(bits); }

struct SoftTextureParams {
  uint32_t samples = 64;  // light samples, 1 to 1,024
  uint64_t seed = 1;      // of the jitter
  bool radiance = false;  // put the radiance texture into the artifact, next to the counts

  VisibilityMethod method = VisibilityMethod::kAuto;  // makes no difference of itself but of time
  // Of auto and silhouette: neighbouring light samples that use one's outlines of meshes; 1: each
  // has its own, exactly.
  uint32_t silhouette_reuse = 1;

  // Of radiance.
  Shading shading = Shading::kProduct;
  float form_factor_error = 1e-3f;  // relative bound at each texel, [0, 0.1]
  Vec3 ambient{0.0f};               // reaches every texel, W·m⁻²·sr⁻¹
  RadianceFormat output = RadianceFormat::kFloat32;
  float output_scale = 0;  // of unorm outputs, W·m⁻²·sr⁻¹; 0: the most that the texture can reach

  CountBits count_bits = CountBits::kAuto;

  friend bool operator==(const SoftTextureParams&, const SoftTextureParams&) = default;

  static constexpr ParameterInfo kParameters[] = {
      {"samples", "uint", "64", "1 to 1024", "light samples; noise falls with their square root"},
      {"seed", "uint", "1", "any 64-bit number",
       "of the jitter: the same seed gives the same bits"},
      {"radiance", "bool", "false", "", "deliver reflected radiance next to the counts"},
      {"method", "enum", "auto", "auto, coverage, edge_flag, silhouette or gl",
       "how hard shadows are drawn; all give the same counts, where nothing is reused"},
      {"silhouette_reuse", "uint", "1", "1 to 64",
       "of auto and silhouette: neighbouring light samples that share one's outlines; 1: exact"},
      {"shading", "enum", "product", "product or sample_sum",
       "radiance as visible fraction times form factor, or summed over visible samples"},
      {"form_factor_error", "float", "0.001", "0 to 0.1",
       "bound on the unoccluded radiance's relative error at a texel; 0: closed form everywhere"},
      {"ambient", "rgb", "0 0 0", "at least 0",
       "radiance that reaches every texel, in W·m⁻²·sr⁻¹; in radiance only"},
      {"output", "enum", "float32", "float32, half, unorm16 or unorm8",
       "what radiance is rounded to, held and sent in"},
      {"output_scale", "float", "0", "0 to 1e30",
       "radiance, in W·m⁻²·sr⁻¹, that is 1 in unorm outputs; 0: the most that nothing hides"},
      {"count_bits", "enum", "auto", "auto, 8 or 16",
       "bits that a count is sent in; auto: 8 for up to 255 samples"},
  };
  static constexpr TechniqueInfo kInfo = {
      .name = "soft_texture",
      .summary =
          "Textures for flat receivers: at each texel, the exact number of light samples that see "
          "it.",
      .artifact_kind = "soft_shadow_texture",
      .source = "Herf 1997, Efficient Generation of Soft Shadow Textures, CMU-CS-97-138",
      .parameters = kParameters,
  };
};

// Whether samples are drawn with outlines that others see.
constexpr bool BorrowsOutlines(const SoftTextureParams& params) {
  return params.silhouette_reuse > 1 && (params.method == VisibilityMethod::kAuto ||
                                         params.method == VisibilityMethod::kSilhouette);
}

}  // namespace penumbra
