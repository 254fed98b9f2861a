// What a scene may hold. The server reports these numbers in GetServerInfo.
#pragma once

#include <cstdint>

namespace penumbra {

struct SceneLimits {
  // A 10-million-triangle mesh is 120 MB of indices; past that a mesh should be split.
  uint64_t max_vertices_per_mesh = 16'000'000;
  uint64_t max_triangles_per_mesh = 16'000'000;
  uint64_t max_instances = 65'536;
  uint64_t max_lights = 1'024;
  uint64_t max_receivers = 4'096;
  // Over all instances, each counted as often as it is placed.
  uint64_t max_triangles_per_scene = 64'000'000;
  // A texel grid's side; llvmpipe's texture limit is 16,384.
  uint32_t max_receiver_side = 16'384;
  // 2^26 texels of 2 bytes are 128 MiB of counts.
  uint64_t max_receiver_texels = uint64_t{1} << 26;
  uint32_t max_light_samples = 1'024;
  uint32_t max_mask_side = 16'384;
  // Larger coordinates overflow single precision when squared three times over.
  float max_coordinate = 1e9f;
  uint32_t max_id_bytes = 128;
  // Checking that a polygon is simple compares its edges pairwise: 5 ms for so many.
  uint32_t max_polygon_vertices = 1'024;
  // Of all meshes together of which one commit wants the planar surfaces: it waits 0.6 s for each
  // million.
  uint64_t max_surface_triangles = 4'000'000;
};

}  // namespace penumbra
