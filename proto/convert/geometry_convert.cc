#include "proto/convert/geometry_convert.h"

#include <algorithm>

#include "render/scene/field_error.h"

namespace penumbra {

v1::Vec3 ToProto(Vec3 v) {
  v1::Vec3 proto;
  proto.set_x(v.x);
  proto.set_y(v.y);
  proto.set_z(v.z);
  return proto;
}

Vec3 FromProto(const v1::Vec3& v) { return {v.x(), v.y(), v.z()}; }

v1::DVec3 ToProto(DVec3 v) {
  v1::DVec3 proto;
  proto.set_x(v.x);
  proto.set_y(v.y);
  proto.set_z(v.z);
  return proto;
}

DVec3 FromProto(const v1::DVec3& v) { return {v.x(), v.y(), v.z()}; }

v1::Parallelogram ToProto(const Parallelogram& patch) {
  v1::Parallelogram proto;
  *proto.mutable_origin() = ToProto(patch.origin);
  *proto.mutable_edge_u() = ToProto(patch.edge_u);
  *proto.mutable_edge_v() = ToProto(patch.edge_v);
  return proto;
}

Parallelogram FromProto(const v1::Parallelogram& patch) {
  Parallelogram result;
  if (patch.has_origin()) result.origin = FromProto(patch.origin());
  if (patch.has_edge_u()) result.edge_u = FromProto(patch.edge_u());
  if (patch.has_edge_v()) result.edge_v = FromProto(patch.edge_v());
  return result;
}

v1::Camera ToProto(const View& view) {
  v1::Camera proto;
  *proto.mutable_eye() = ToProto(view.camera.eye);
  *proto.mutable_target() = ToProto(view.camera.target);
  *proto.mutable_up() = ToProto(view.camera.up);
  proto.set_fov_y_deg(view.camera.fov_y_deg);
  proto.set_aspect(static_cast<float>(view.aspect));
  return proto;
}

Camera CameraFromProto(const v1::Camera& proto) {
  Camera camera{.eye = Vec3(0), .target = Vec3(0, 0, -1)};
  if (proto.has_eye()) camera.eye = FromProto(proto.eye());
  if (proto.has_target()) camera.target = FromProto(proto.target());
  if (proto.has_up()) camera.up = FromProto(proto.up());
  if (proto.has_fov_y_deg()) camera.fov_y_deg = proto.fov_y_deg();
  return camera;
}

absl::StatusOr<View> FromProto(const v1::Camera& proto) {
  View view{.camera = CameraFromProto(proto)};
  if (proto.has_aspect()) view.aspect = double{proto.aspect()};
  if (absl::Status status = CheckView(view); !status.ok()) return status;
  return view;
}

std::string ToProto(const ContentHash& hash) {
  return std::string(hash.bytes.begin(), hash.bytes.end());
}

absl::StatusOr<ContentHash> HashFromProto(const std::string& bytes, std::string_view field_path) {
  ContentHash hash;
  if (bytes.size() != hash.bytes.size()) {
    return FieldError(absl::StatusCode::kInvalidArgument, "LENGTH", field_path,
                      "found " + std::to_string(bytes.size()) + " bytes, need a hash of 32");
  }
  std::copy(bytes.begin(), bytes.end(), hash.bytes.begin());
  return hash;
}

}  // namespace penumbra
