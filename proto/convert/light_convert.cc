#include "proto/convert/light_convert.h"

#include <string>

#include "proto/convert/geometry_convert.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

// One overload of Write a kind of light: a new kind does not compile without one.
void Write(const RectangleLight& light, v1::Light& proto) {
  auto& shape = *proto.mutable_rectangle();
  *shape.mutable_corner() = ToProto(light.corner);
  *shape.mutable_edge_u() = ToProto(light.edge_u);
  *shape.mutable_edge_v() = ToProto(light.edge_v);
  *shape.mutable_radiance() = ToProto(light.radiance);
  shape.set_two_sided(light.two_sided);
}

void Write(const DiskLight& light, v1::Light& proto) {
  auto& shape = *proto.mutable_disk();
  *shape.mutable_center() = ToProto(light.center);
  *shape.mutable_normal() = ToProto(light.normal);
  shape.set_radius(light.radius);
  *shape.mutable_radiance() = ToProto(light.radiance);
  shape.set_two_sided(light.two_sided);
}

void Write(const SphereLight& light, v1::Light& proto) {
  auto& shape = *proto.mutable_sphere();
  *shape.mutable_center() = ToProto(light.center);
  shape.set_radius(light.radius);
  *shape.mutable_radiance() = ToProto(light.radiance);
}

void Write(const PointLight& light, v1::Light& proto) {
  auto& shape = *proto.mutable_point();
  *shape.mutable_position() = ToProto(light.position);
  *shape.mutable_intensity() = ToProto(light.intensity);
}

void Write(const SpotLight& light, v1::Light& proto) {
  auto& shape = *proto.mutable_spot();
  *shape.mutable_position() = ToProto(light.position);
  *shape.mutable_direction() = ToProto(light.direction);
  *shape.mutable_intensity() = ToProto(light.intensity);
  shape.set_inner_angle(light.inner_angle);
  shape.set_outer_angle(light.outer_angle);
}

void Write(const DistantLight& light, v1::Light& proto) {
  auto& shape = *proto.mutable_distant();
  *shape.mutable_to_light() = ToProto(light.to_light);
  shape.set_angular_diameter(light.angular_diameter);
  *shape.mutable_irradiance() = ToProto(light.irradiance);
}

RectangleLight Read(const v1::RectangleLight& proto) {
  RectangleLight light;
  if (proto.has_corner()) light.corner = FromProto(proto.corner());
  if (proto.has_edge_u()) light.edge_u = FromProto(proto.edge_u());
  if (proto.has_edge_v()) light.edge_v = FromProto(proto.edge_v());
  if (proto.has_radiance()) light.radiance = FromProto(proto.radiance());
  if (proto.has_two_sided()) light.two_sided = proto.two_sided();
  return light;
}

DiskLight Read(const v1::DiskLight& proto) {
  DiskLight light;
  if (proto.has_center()) light.center = FromProto(proto.center());
  if (proto.has_normal()) light.normal = FromProto(proto.normal());
  if (proto.has_radius()) light.radius = proto.radius();
  if (proto.has_radiance()) light.radiance = FromProto(proto.radiance());
  if (proto.has_two_sided()) light.two_sided = proto.two_sided();
  return light;
}

SphereLight Read(const v1::SphereLight& proto) {
  SphereLight light;
  if (proto.has_center()) light.center = FromProto(proto.center());
  if (proto.has_radius()) light.radius = proto.radius();
  if (proto.has_radiance()) light.radiance = FromProto(proto.radiance());
  return light;
}

PointLight Read(const v1::PointLight& proto) {
  PointLight light;
  if (proto.has_position()) light.position = FromProto(proto.position());
  if (proto.has_intensity()) light.intensity = FromProto(proto.intensity());
  return light;
}

SpotLight Read(const v1::SpotLight& proto) {
  SpotLight light;
  if (proto.has_position()) light.position = FromProto(proto.position());
  if (proto.has_direction()) light.direction = FromProto(proto.direction());
  if (proto.has_intensity()) light.intensity = FromProto(proto.intensity());
  if (proto.has_inner_angle()) light.inner_angle = proto.inner_angle();
  if (proto.has_outer_angle()) light.outer_angle = proto.outer_angle();
  return light;
}

DistantLight Read(const v1::DistantLight& proto) {
  DistantLight light;
  if (proto.has_to_light()) light.to_light = FromProto(proto.to_light());
  if (proto.has_angular_diameter()) light.angular_diameter = proto.angular_diameter();
  if (proto.has_irradiance()) light.irradiance = FromProto(proto.irradiance());
  return light;
}

}  // namespace

v1::Light ToProto(const AreaLight& light) {
  v1::Light proto;
  proto.set_id(light.id);
  std::visit([&](const auto& shape) { Write(shape, proto); }, light.shape);
  return proto;
}

absl::StatusOr<AreaLight> FromProto(const v1::Light& light, std::string_view field_path) {
  switch (light.shape_case()) {
    case v1::Light::kRectangle:
      return AreaLight{light.id(), Read(light.rectangle())};
    case v1::Light::kDisk:
      return AreaLight{light.id(), Read(light.disk())};
    case v1::Light::kSphere:
      return AreaLight{light.id(), Read(light.sphere())};
    case v1::Light::kPoint:
      return AreaLight{light.id(), Read(light.point())};
    case v1::Light::kSpot:
      return AreaLight{light.id(), Read(light.spot())};
    case v1::Light::kDistant:
      return AreaLight{light.id(), Read(light.distant())};
    case v1::Light::SHAPE_NOT_SET:
      break;
  }
  return FieldError(absl::StatusCode::kInvalidArgument, "MISSING_FIELD",
                    std::string(field_path) + ".shape",
                    "found none that this server knows, need a rectangle, disk, sphere, point, "
                    "spot or distant light");
}

}  // namespace penumbra
