#include "render/technique/shadow_volume/shadow_volume_builder.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/scene/caster_tree.h"
#include "render/scene/field_error.h"
#include "render/technique/shadow_volume/volume_hash.h"
#include "render/technique/shadow_volume/wall_fit.h"

namespace penumbra {

absl::StatusOr<ReconstructedVolume> ReconstructVolume(std::vector<VolumeFace> faces,
                                                      const ShadowVolumeOptions& options,
                                                      const std::stop_token& stop,
                                                      std::span<const std::vector<uint32_t>> ids) {
  ReconstructedVolume result;
  VolumeTriangles mesh;
  size_t flags = 0, places = 0;
  for (size_t i = 0; i < faces.size(); ++i) {
    if (stop.stop_requested()) return absl::CancelledError("stopped");
    const VolumeGrid grid(faces[i].map, faces[i].border, options.bias_px);
    const std::span<const uint32_t> face_ids =
        i < ids.size() ? std::span(ids[i]) : std::span<const uint32_t>();
    const EdgeMap edges = FindEdges(grid, options.edges, face_ids);
    if (stop.stop_requested()) return absl::CancelledError("stopped");
    if (options.vectorizes) {
      AddWalls(grid, edges, mesh);
    } else {
      AddTriangles(grid, edges, options.reconstruction, mesh);
    }
    flags += edges.flag_count(), places += edges.place_count();
    const size_t triangles = mesh.indices.size() / 3 + (mesh.is_cut_off ? kMaxVolumeTriangles : 0);
    const auto status = CheckVolumeSize(triangles, mesh.vertices.size());
    if (!status.ok()) return status;
  }
  result.places = places;
  if (places > 0) result.edge_fraction = static_cast<double>(flags) / static_cast<double>(places);
  result.volume.kind = options.vectorizes ? VolumeKind::kVectorized : VolumeKind::kReconstructed;
  result.volume.faces = std::move(faces);
  result.volume.vertices = std::move(mesh.vertices);
  result.volume.indices = std::move(mesh.indices);
  return result;
}

absl::StatusOr<std::vector<VolumeFace>> DrawFaces(std::span<const VolumeView> views,
                                                  DepthSource& source,
                                                  const std::stop_token& stop) {
  std::vector<LightView> light_views;
  for (const VolumeView& view : views) light_views.push_back(view.view);
  std::vector<DepthMap> maps;
  const auto status = source.Draw(light_views, stop, [&](size_t, DepthMap map) {
    maps.push_back(std::move(map));
    return absl::OkStatus();
  });
  if (!status.ok()) return status;
  JoinBorders(maps);
  std::vector<VolumeFace> faces;
  for (size_t i = 0; i < maps.size(); ++i) {
    faces.push_back({.map = std::move(maps[i]), .border = views[i].border});
  }
  return faces;
}

absl::Status CheckVolumeTexels(uint64_t so_far, std::span<const VolumeView> views) {
  uint64_t texels = so_far;
  for (const VolumeView& view : views) texels += uint64_t{view.view.width} * view.view.height;
  if (texels <= kMaxVolumeTexels) return absl::OkStatus();
  return FieldError(absl::StatusCode::kResourceExhausted, "QUOTA_VOLUME_TEXELS", "resolution",
                    absl::StrCat("found one at which the light's maps have ", texels,
                                 " texels or more, need at most ", kMaxVolumeTexels));
}

absl::Status CheckVolumeSize(size_t triangles, size_t vertices) {
  if (triangles <= kMaxVolumeTriangles && vertices <= kMaxVolumeVertices) return absl::OkStatus();
  return FieldError(absl::StatusCode::kResourceExhausted, "QUOTA_VOLUME_TRIANGLES", "resolution",
                    absl::StrCat("found one, or thresholds, at which the boundary has more than ",
                                 kMaxVolumeTriangles, " triangles or ", kMaxVolumeVertices,
                                 " vertices, need fewer"));
}

absl::StatusOr<ShadowVolumeMesh> BuildShadowVolumes(const Scene& scene, const AreaLight& light,
                                                    const ShadowVolumeOptions& options,
                                                    DepthSource& source,
                                                    const std::stop_token& stop,
                                                    const InstancesOf& instances_of) {
  if (const auto status = CheckShadowVolumeOptions(options); !status.ok()) return status;
  ShadowVolumeMesh mesh{.light = light, .bias_px = options.bias_px, .volumes = {}};
  const std::vector<Aabb>& boxes = scene.casters().bounds();
  Aabb bounds;
  for (const Aabb& box : boxes) bounds.Add(box);
  const auto views = VolumeViews(light, boxes, PitchFor(light, bounds, options.resolution));
  if (views.empty()) return mesh;
  if (const auto status = CheckVolumeTexels(0, views); !status.ok()) return status;
  auto faces = DrawFaces(views, source, stop);
  if (!faces.ok()) return faces.status();
  std::vector<std::vector<uint32_t>> ids;
  for (size_t i = 0; options.has_instance_edges && i < faces->size(); ++i) {
    auto seen = instances_of((*faces)[i].map.view);
    if (!seen.ok()) return seen.status();
    ids.push_back(*std::move(seen));
  }
  auto built = ReconstructVolume(*std::move(faces), options, stop, ids);
  if (!built.ok()) return built.status();
  built->volume.content = HashOfVolume(scene.content_hash(), light, options);
  mesh.edge_fraction = static_cast<float>(built->edge_fraction);
  mesh.volumes.push_back(std::make_shared<ShadowVolume>(std::move(built->volume)));
  return mesh;
}

}  // namespace penumbra
