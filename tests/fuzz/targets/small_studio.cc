#include "tests/fuzz/targets/small_studio.h"

#include <utility>

#include "tests/support/shapes.h"

namespace penumbra::fuzzing {
namespace {

using testing::Placed;

std::vector<AreaLight> LightsOfEachKind() {
  return {
      {"lamp",
       RectangleLight{
           .corner = {-0.5f, 3, -0.5f}, .edge_u = {1, 0, 0}, .edge_v = {0, 0, 1}, .radiance = {}}},
      {"disk", DiskLight{.center = {1, 3, 0}, .radius = 0.25f, .two_sided = false}},
      {"ball", SphereLight{.center = {-1, 2, 1}, .radius = 0.2f}},
      {"bulb", PointLight{.position = {0, 2.5f, 1}}},
      {"spot", SpotLight{.position = {2, 3, 0}, .inner_angle = 0.2f, .outer_angle = 0.6f}},
      {"sun", DistantLight{.to_light = {0.3f, 1, 0.2f}, .angular_diameter = 0.00925f}},
  };
}

std::vector<Receiver> ReceiversOfEachShape() {
  return {
      testing::FloorReceiver("floor", 4, 16),
      {.id = "on-ground", .shape = PlanarInstance{.instance_id = "ground"}},
      {.id = "triangle",
       .shape = Triangle{.corner = {0, 0.01f, 0}, .edge_u = {1, 0, 0}, .edge_v = {0, 0, -1}},
       .width = 9,
       .height = 7},
      {.id = "polygon",
       .shape = PlanarPolygon{.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 0, -1}, {0.4f, 0, -0.3f}}},
       .texels_per_metre = 8,
       .max_auto_side = 16},
      {.id = "side",
       .shape = PlanarSurface{.instance_id = "box", .triangle = 4},
       .two_sided = false,
       .reflectance = {0.5f, 0.25f, 1}},
  };
}

}  // namespace

std::shared_ptr<const Mesh> StudioBox() {
  static const auto mesh = testing::MeshOf(testing::UnitBoxGeometry());
  return mesh;
}

std::shared_ptr<const Mesh> StudioSquare() {
  static const auto mesh = testing::MeshOf(testing::UnitSquareGeometry());
  return mesh;
}

std::shared_ptr<const AlphaMask> StudioMask() {
  static const auto mask = AlphaMask::Create(3, 2, {0, 255, 127, 128, 1, 254}).value();
  return mask;
}

KnownBlobs StudioBlobs() {
  KnownBlobs blobs;
  blobs.Add(StudioBox());
  blobs.Add(StudioSquare());
  blobs.Add(StudioMask());
  return blobs;
}

SceneDelta StudioDelta() {
  SceneDelta delta;
  delta.upsert_instances = {
      {.id = "ground", .mesh = StudioSquare(), .world_from_mesh = Placed({0, 0, 0}, 2)},
      {.id = "box", .mesh = StudioBox(), .world_from_mesh = Placed({0, 0.5f, 0}, 0.25f)},
      {.id = "fence",
       .mesh = StudioSquare(),
       .world_from_mesh = Affine({0.5f, 0, 0}, {0, 0, 1}, {0, 0.5f, 0}, {0.5f, 0.5f, 0.5f}),
       .color = {0.1f, 0.2f, 0.3f},
       .alpha_mask = StudioMask()},
  };
  delta.upsert_lights = LightsOfEachKind();
  delta.upsert_receivers = ReceiversOfEachShape();
  return delta;
}

SceneDelta BoxAt(float x) {
  SceneDelta delta;
  delta.upsert_instances = {
      {.id = "box", .mesh = StudioBox(), .world_from_mesh = Placed({x, 0.5f, 0}, 0.25f)}};
  return delta;
}

SceneLimits SmallLimits() {
  return {.max_vertices_per_mesh = 1'000,
          .max_triangles_per_mesh = 1'000,
          .max_instances = 32,
          .max_lights = 24,
          .max_receivers = 32,
          .max_triangles_per_scene = 2'000,
          .max_receiver_side = 256,  // kMaxAutoSide
          .max_receiver_texels = 1u << 16,
          .max_light_samples = 64,
          .max_mask_side = 64,
          .max_polygon_vertices = 32,
          .max_surface_triangles = 500};
}

}  // namespace penumbra::fuzzing
