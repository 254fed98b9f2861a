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
