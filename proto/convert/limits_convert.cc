// The limits of scenes.

#include "proto/convert/scene_convert.h"

namespace penumbra {

SceneLimits SceneLimitsFromProto(const v1::Limits& proto) {
  SceneLimits limits;
  const auto take = [](auto told, auto& limit) {
    if (told > 0) limit = told;
  };
  take(proto.max_vertices_per_mesh(), limits.max_vertices_per_mesh);
  take(proto.max_triangles_per_mesh(), limits.max_triangles_per_mesh);
  take(proto.max_instances(), limits.max_instances);
  take(proto.max_lights(), limits.max_lights);
  take(proto.max_receivers(), limits.max_receivers);
  take(proto.max_triangles_per_scene(), limits.max_triangles_per_scene);
  take(proto.max_receiver_side(), limits.max_receiver_side);
  take(proto.max_receiver_texels(), limits.max_receiver_texels);
  take(proto.max_light_samples(), limits.max_light_samples);
  take(proto.max_mask_side(), limits.max_mask_side);
  take(proto.max_coordinate(), limits.max_coordinate);
  take(proto.max_id_bytes(), limits.max_id_bytes);
  take(proto.max_polygon_vertices(), limits.max_polygon_vertices);
  take(proto.max_surface_triangles(), limits.max_surface_triangles);
  return limits;
}

void WriteSceneLimits(const SceneLimits& limits, v1::Limits& proto) {
  proto.set_max_vertices_per_mesh(limits.max_vertices_per_mesh);
  proto.set_max_triangles_per_mesh(limits.max_triangles_per_mesh);
  proto.set_max_instances(limits.max_instances);
  proto.set_max_lights(limits.max_lights);
  proto.set_max_receivers(limits.max_receivers);
  proto.set_max_triangles_per_scene(limits.max_triangles_per_scene);
  proto.set_max_receiver_side(limits.max_receiver_side);
  proto.set_max_receiver_texels(limits.max_receiver_texels);
  proto.set_max_light_samples(limits.max_light_samples);
  proto.set_max_mask_side(limits.max_mask_side);
  proto.set_max_coordinate(limits.max_coordinate);
  proto.set_max_id_bytes(limits.max_id_bytes);
  proto.set_max_polygon_vertices(limits.max_polygon_vertices);
  proto.set_max_surface_triangles(limits.max_surface_triangles);
}

}  // namespace penumbra
