// Parameters of coherent_raytrace.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "render/artifact/radiance_format.h"
#include "render/technique/technique_info.h"

namespace penumbra {

// What shadow rays are traced through.
enum class RayBackend : uint8_t {
  kAuto,         // triangles
  kTriangles,    // the scene's own, by Embree
  kDepthImages,  // depth maps from points of the light
};

// In the order of the backends.
inline constexpr std::array<std::string_view, 3> kRayBackendNames = {"auto", "triangles",
                                                                     "depth_images"};

inline constexpr uint32_t kMaxReferenceResolution = 8'192;

struct CoherentRaytraceParams {
  uint32_t samples = 256;  // 1 to 1,024, rounded down to a square: one for each cell of the light
  uint64_t seed = 1;       // of the jitter
  RayBackend backend = RayBackend::kAuto;
  bool radiance = true;                           // deliver what reaches points next to counts
  RadianceFormat output = RadianceFormat::kHalf;  // of radiance; no unorm

  // Switches that cost nothing in quality; for measuring, and where one is in doubt.
  bool coherence = true;    // predict a point's visibility from that of the points before it
  bool whole_light = true;  // of depth images: prove all of the light seen where a pyramid can
  bool ray_accelerations = true;  // all five of depth images, §5.1.1 and §5.1.2

  float prediction_distance = 0.0f;  // m between points beyond which none is predicted; 0: auto
  // Of depth images.
  uint32_t resolution = 1'536;  // pixels along the longer side
  float gap_bias = 0.0f;        // m between neighbours that are connected; 0: auto
  float shadow_bias = 0.0f;     // m that a ray is lifted off its surface; 0: auto

  friend bool operator==(const CoherentRaytraceParams&, const CoherentRaytraceParams&) = default;

  static constexpr ParameterInfo kParameters[] = {
      {"samples", "uint", "256", "1 to 1024",
       "light samples at each point, rounded down to a square number"},
      {"seed", "uint", "1", "any 64-bit number",
       "of the jitter: the same seed gives the same bits"},
      {"backend", "enum", "auto", "auto, triangles or depth_images",
       "what shadow rays are traced through; auto: triangles"},
      {"radiance", "bool", "true", "",
       "deliver what a white diffuse surface would reflect next to the counts"},
      {"output", "enum", "half", "float32 or half",
       "what radiance is rounded to, held and sent in"},
      {"coherence", "bool", "true", "",
       "trace only where a point's visibility is likely to differ from its neighbour's"},
      {"whole_light", "bool", "true", "",
       "of depth images: prove all of the light seen without a ray where possible"},
      {"ray_accelerations", "bool", "true", "",
       "of depth images: connectedness, clipping, ranking, clear misses, occlusion intervals"},
      {"prediction_distance", "float", "0", "at least 0",
       "metres between points beyond which nothing is predicted; 0: by the points' spacing and the "
       "light's width"},
      {"resolution", "uint", "1536", "1 to 8192", "of depth images: pixels along the longer side"},
      {"gap_bias", "float", "0", "at least 0",
       "of depth images: metres between neighbouring depths of one surface; 0: by their footprint"},
      {"shadow_bias", "float", "0", "at least 0",
       "metres that rays begin above their surface; 0: by the scene's size, of depth images by "
       "their pixels"},
  };
  static constexpr TechniqueInfo kInfo = {
      .name = "coherent_raytrace",
      .summary =
          "The final picture: soft shadows at the pixels of a camera, the texels of a lightmap or "
          "given points, with samples of their own for each point.",
      .artifact_kind = "view_shadow",
      .target = SpecTarget::kPoints,
      .source =
          "Agrawala, Ramamoorthi, Heirich and Moll 2000, Efficient Image-Based Methods for "
          "Rendering Soft Shadows, SIGGRAPH",
      .parameters = kParameters,
  };
};

}  // namespace penumbra
