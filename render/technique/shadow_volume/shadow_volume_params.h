// Parameters of shadow_volume.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "render/light_view/depth_method.h"
#include "render/technique/technique_info.h"

namespace penumbra {

inline constexpr uint32_t kMinVolumeResolution = 8, kMaxVolumeResolution = 8'192;
// In pixels' widths.
inline constexpr float kMaxVolumeBias = 64.0f;
inline constexpr float kMaxEdgeThreshold = 1e6f;
// Of all maps together: half a gigabyte with what is made of them. As many as a client takes.
inline constexpr uint64_t kMaxVolumeTexels = uint64_t{1} << 26;

// What a shadow's boundary is made of.
enum class VolumeSurface : uint8_t {
  kTemplate,  // triangles between samples, those of a cell by where its edges are
  kFixed,     // both triangles of each cell with an edge
  kAll,       // every cell
  kLines,     // walls along lines that are fitted to the edges
};

// In the order of the surfaces.
inline constexpr std::array<std::string_view, 4> kVolumeSurfaceNames = {"template", "fixed", "all",
                                                                        "lines"};

constexpr std::string_view NameOf(VolumeSurface surface) {
  return kVolumeSurfaceNames[static_cast<size_t>(surface)];
}

// Of what there is one volume each.
enum class VolumesOf : uint8_t {
  kScene,      // all casters
  kInstances,  // each caster, from a map of it alone
  kEdges,      // each caster, from its own edges where it has few triangles and no mask
};

inline constexpr std::array<std::string_view, 3> kVolumesOfNames = {"scene", "instances", "edges"};

constexpr std::string_view NameOf(VolumesOf volumes_of) {
  return kVolumesOfNames[static_cast<size_t>(volumes_of)];
}

struct ShadowVolumeParams {
  uint32_t resolution = 512;    // samples along the longer side of a view, and of each of six
  float bias = 0.25f;           // how far behind the samples the surface is, in pixels' widths
  float low_threshold = 0.0f;   // of differences in depth that may be edges; 0: by the map
  float high_threshold = 0.0f;  // of those that are edges; 0: four times the low one
  VolumeSurface surface = VolumeSurface::kTemplate;
  VolumesOf volumes_of = VolumesOf::kScene;
  bool object_ids = false;                  // an edge too where the light sees another instance
  DepthMethod source = DepthMethod::kAuto;  // what draws the depth maps

  friend bool operator==(const ShadowVolumeParams&, const ShadowVolumeParams&) = default;

  static constexpr ParameterInfo kParameters[] = {
      {"resolution", "uint", "512", "8 to 8192",
       "samples along the longer side of a view, and of each of six"},
      {"bias", "float", "0.25", "0 to 64",
       "how far behind the depth samples the surface is, in pixels' widths"},
      {"low_threshold", "float", "0", "0 to 1000000",
       "differences in depth above which there may be an edge, in pixels' widths; 0: by the map"},
      {"high_threshold", "float", "0", "0 to 1000000",
       "differences above which there is one; 0: four times the low one"},
      {"surface", "enum", "template", "template, fixed, all or lines",
       "what the boundary is made of: the triangles of cells with an edge, both of each, those of "
       "every cell, or walls along fitted lines"},
      {"volumes_of", "enum", "scene", "scene, instances or edges",
       "one volume of all casters; one of each, of which an edit makes few anew; the same from a "
       "caster's own edges where it has few triangles"},
      {"object_ids", "bool", "false", "",
       "an edge too wherever the light sees another instance; of volumes of the scene"},
      {"source", "enum", "auto", "auto, raster, rays or gl",
       "what draws depth maps; auto: raster, rays or both, whichever costs least for a view"},
  };
  static constexpr TechniqueInfo kInfo = {
      .name = "shadow_volume",
      .summary =
          "Hard shadows for any renderer with a one-bit stencil, on all surfaces and for any view: "
          "the boundary of the shadow of the light's middle, as a mesh made from what it sees.",
      .artifact_kind = "shadow_volume_mesh",
      .target = SpecTarget::kScene,
      .is_plausible = true,
      .source =
          "McCool 2000, Shadow Volume Reconstruction from Depth Maps, ACM Transactions on Graphics "
          "19, 1",
      .parameters = kParameters,
  };
};

}  // namespace penumbra
