// Receivers, and the request for one on every planar surface.

#include <string>
#include <variant>

#include "proto/convert/geometry_convert.h"
#include "proto/convert/scene_convert.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

// One overload of Write a shape: a new one does not compile without.
void Write(const Parallelogram& patch, v1::Receiver& proto) {
  *proto.mutable_parallelogram() = ToProto(patch);
}
void Write(const PlanarInstance& planar, v1::Receiver& proto) {
  proto.mutable_planar_instance()->set_instance_id(planar.instance_id);
}
void Write(const Triangle& triangle, v1::Receiver& proto) {
  *proto.mutable_triangle()->mutable_corner() = ToProto(triangle.corner);
  *proto.mutable_triangle()->mutable_edge_u() = ToProto(triangle.edge_u);
  *proto.mutable_triangle()->mutable_edge_v() = ToProto(triangle.edge_v);
}
void Write(const PlanarPolygon& polygon, v1::Receiver& proto) {
  for (const Vec3& v : polygon.vertices) {
    for (int c = 0; c < 3; ++c) proto.mutable_polygon()->add_vertices(v[c]);
  }
}
void Write(const PlanarSurface& surface, v1::Receiver& proto) {
  proto.mutable_planar_surface()->set_instance_id(surface.instance_id);
  proto.mutable_planar_surface()->set_triangle(surface.triangle);
}

Triangle Read(const v1::Triangle& proto) {
  Triangle triangle;
  if (proto.has_corner()) triangle.corner = FromProto(proto.corner());
  if (proto.has_edge_u()) triangle.edge_u = FromProto(proto.edge_u());
  if (proto.has_edge_v()) triangle.edge_v = FromProto(proto.edge_v());
  return triangle;
}

absl::StatusOr<PlanarPolygon> Read(const v1::PlanarPolygon& proto, const std::string& path) {
  if (proto.vertices_size() % 3 != 0) {
    return FieldError(
        absl::StatusCode::kInvalidArgument, "LENGTH", path + ".vertices",
        "found " + std::to_string(proto.vertices_size()) + " numbers, need three for each vertex");
  }
  PlanarPolygon polygon;
  for (int i = 0; i < proto.vertices_size(); i += 3) {
    polygon.vertices.emplace_back(proto.vertices(i), proto.vertices(i + 1), proto.vertices(i + 2));
  }
  return polygon;
}

absl::StatusOr<ReceiverShape> ReadShape(const v1::Receiver& proto, const std::string& path) {
  switch (proto.shape_case()) {
    case v1::Receiver::kParallelogram:
      return FromProto(proto.parallelogram());
    case v1::Receiver::kPlanarInstance:
      return PlanarInstance{proto.planar_instance().instance_id()};
    case v1::Receiver::kTriangle:
      return Read(proto.triangle());
    case v1::Receiver::kPolygon:
      return Read(proto.polygon(), path);
    case v1::Receiver::kPlanarSurface:
      return PlanarSurface{proto.planar_surface().instance_id(), proto.planar_surface().triangle()};
    case v1::Receiver::SHAPE_NOT_SET:
      break;
  }
  return FieldError(absl::StatusCode::kInvalidArgument, "MISSING_FIELD", path + ".shape",
                    "found none that this server knows, need a parallelogram, a planar instance, "
                    "a triangle, a polygon or a planar surface");
}

}  // namespace

v1::Receiver ToProto(const Receiver& receiver) {
  v1::Receiver proto;
  proto.set_id(receiver.id);
  std::visit([&](const auto& shape) { Write(shape, proto); }, receiver.shape);
  if (receiver.width > 0) proto.set_width(receiver.width);
  if (receiver.height > 0) proto.set_height(receiver.height);
  proto.set_two_sided(receiver.two_sided);
  *proto.mutable_reflectance() = ToProto(receiver.reflectance);
  proto.set_texels_per_metre(receiver.texels_per_metre);
  proto.set_max_auto_side(receiver.max_auto_side);
  return proto;
}

absl::StatusOr<Receiver> FromProto(const v1::Receiver& proto, std::string_view field_path) {
  auto shape = ReadShape(proto, std::string(field_path));
  if (!shape.ok()) return shape.status();
  Receiver receiver{.id = proto.id(),
                    .shape = *std::move(shape),
                    .width = proto.width(),
                    .height = proto.height(),
                    .texels_per_metre = proto.texels_per_metre(),
                    .max_auto_side = proto.max_auto_side()};
  if (proto.has_two_sided()) receiver.two_sided = proto.two_sided();
  if (proto.has_reflectance()) receiver.reflectance = FromProto(proto.reflectance());
  return receiver;
}

v1::ReceiveOnPlanarSurfaces ToProto(const PlanarSurfaceRequest& request) {
  v1::ReceiveOnPlanarSurfaces proto;
  proto.set_min_area_m2(request.min_area_m2);
  proto.set_texels_per_metre(request.texels_per_metre);
  proto.set_max_auto_side(request.max_auto_side);
  proto.set_max_receivers(request.max_receivers);
  proto.set_id_prefix(request.id_prefix);
  return proto;
}

PlanarSurfaceRequest FromProto(const v1::ReceiveOnPlanarSurfaces& proto) {
  PlanarSurfaceRequest request{.min_area_m2 = proto.min_area_m2(),
                               .max_receivers = proto.max_receivers(),
                               .texels_per_metre = proto.texels_per_metre(),
                               .max_auto_side = proto.max_auto_side()};
  if (!proto.id_prefix().empty()) request.id_prefix = proto.id_prefix();
  return request;
}

}  // namespace penumbra
