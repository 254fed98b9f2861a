// The boundary of a light's shadow, from a scene.
//
//   auto mesh = BuildShadowVolumes(*scene, light, options, source, stop);
//   if (!mesh.ok()) return mesh.status();
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <stop_token>
#include <vector>

#include "absl/status/statusor.h"
#include "render/artifact/shadow_volume_mesh.h"
#include "render/light_view/depth_source.h"
#include "render/scene/scene.h"
#include "render/technique/shadow_volume/shadow_volume_options.h"
#include "render/technique/shadow_volume/volume_views.h"

namespace penumbra {

// A volume without a name, and how many of the places for edges have one: of all between two
// samples of which one sees something, on whichever map they are.
struct ReconstructedVolume {
  ShadowVolume volume;
  double edge_fraction = 0;
  size_t places = 0;
};

// From maps of VolumeViews, the borders of which are joined.
//
// ids     of the objects that samples are on, one vector a map, row by row; empty: not known
// Errors  kCancelled: stop requested, which is asked for once a map; those of CheckVolumeSize
// Cost    about 3 ns a sample and 0.1 µs a cell with an edge
absl::StatusOr<ReconstructedVolume> ReconstructVolume(
    std::vector<VolumeFace> faces, const ShadowVolumeOptions& options, const std::stop_token& stop,
    std::span<const std::vector<uint32_t>> ids = {});

// Errors  kResourceExhausted QUOTA_VOLUME_TRIANGLES, at "resolution": more than
//         kMaxVolumeTriangles or kMaxVolumeVertices
absl::Status CheckVolumeSize(size_t triangles, size_t vertices);

// Draws the views by `source` and joins their borders.
//
// Errors  those of DepthSource::Draw
absl::StatusOr<std::vector<VolumeFace>> DrawFaces(std::span<const VolumeView> views,
                                                  DepthSource& source, const std::stop_token& stop);

// Errors  kResourceExhausted QUOTA_VOLUME_TEXELS, at "resolution": with `so_far` the views have
//         more than kMaxVolumeTexels
absl::Status CheckVolumeTexels(uint64_t so_far, std::span<const VolumeView> views);

// Of a view, the numbers of the instances that its pixels show.
using InstancesOf = std::function<absl::StatusOr<std::vector<uint32_t>>(const LightView& view)>;

// One volume of all of the scene's casters; none where the light sees nothing of them.
//
// source        draws `scene`
// instances_of  needed where options.has_instance_edges
// Errors        those of CheckShadowVolumeOptions, CheckVolumeTexels, `instances_of`,
//               DepthSource::Draw and ReconstructVolume
absl::StatusOr<ShadowVolumeMesh> BuildShadowVolumes(const Scene& scene, const AreaLight& light,
                                                    const ShadowVolumeOptions& options,
                                                    DepthSource& source,
                                                    const std::stop_token& stop,
                                                    const InstancesOf& instances_of = nullptr);

}  // namespace penumbra
