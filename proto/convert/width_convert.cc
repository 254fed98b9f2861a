#include "proto/convert/width_convert.h"

#include <cmath>
#include <string>
#include <utility>

#include "proto/convert/light_convert.h"
#include "proto/convert/view_convert.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

// The total is bounded too: planes are allocated once the header is there.
absl::Status CheckTexels(const ShadowWidthMap& map, const SceneLimits& limits) {
  uint64_t texels = 0;
  for (const ShadowWidthFace& face : map.faces) {
    texels += uint64_t{face.view.width} * face.view.height;
  }
  if (texels <= limits.max_receiver_texels) return absl::OkStatus();
  return FieldError(absl::StatusCode::kInvalidArgument, "RANGE", "shadow_width_map.faces",
                    "found " + std::to_string(texels) + " texels, need at most " +
                        std::to_string(limits.max_receiver_texels));
}

absl::Status CheckConstant(const char* field, float found) {
  if (std::isfinite(found) && found >= 0) return absl::OkStatus();
  return FieldError(absl::StatusCode::kInvalidArgument, "RANGE", field,
                    "found " + std::to_string(found) + ", need a finite number >= 0");
}

absl::StatusOr<ShadowWidthFace> Read(const v1::ShadowWidthFace& proto, const std::string& field,
                                     const SceneLimits& limits) {
  ShadowWidthFace face{
      .view = FromProto(proto.view()),
      .window = {.min = {proto.min_x(), proto.min_y()}, .max = {proto.max_x(), proto.max_y()}}};
  if (auto status = CheckView(face.view, field + ".view", limits); !status.ok()) return status;
  if (face.view.eye != DVec3(0.0)) {
    return FieldError(absl::StatusCode::kInvalidArgument, "RANGE", field + ".view",
                      "found an eye off the frame's origin, need one there");
  }
  // Not a number is not less.
  if (face.window.empty()) {
    return FieldError(absl::StatusCode::kInvalidArgument, "RANGE", field,
                      "found an empty window, need some of it");
  }
  if (proto.has_far()) face.far.emplace();
  return face;
}

}  // namespace

v1::ShadowWidthMap ToProto(const ShadowWidthMap& map) {
  v1::ShadowWidthMap proto;
  *proto.mutable_light() = ToProto(map.light);
  if (map.c_scale) proto.set_c_scale(*map.c_scale);
  proto.set_c_bias(map.c_bias);
  for (const ShadowWidthFace& face : map.faces) {
    v1::ShadowWidthFace& added = *proto.add_faces();
    *added.mutable_view() = ToProto(face.view);
    added.set_min_x(face.window.min.x);
    added.set_min_y(face.window.min.y);
    added.set_max_x(face.window.max.x);
    added.set_max_y(face.window.max.y);
    added.set_has_far(face.far.has_value());
  }
  return proto;
}

absl::StatusOr<ShadowWidthMap> FromProto(const v1::ShadowWidthMap& proto,
                                         const SceneLimits& limits) {
  auto light = FromProto(proto.light(), "shadow_width_map.light");
  if (!light.ok()) return light.status();
  absl::Status status = CheckFaceCount(proto.faces_size(), "shadow_width_map.faces");
  if (proto.has_c_scale()) {
    status.Update(CheckConstant("shadow_width_map.c_scale", proto.c_scale()));
  }
  status.Update(CheckConstant("shadow_width_map.c_bias", proto.c_bias()));
  if (!status.ok()) return status;
  ShadowWidthMap map{.light = *std::move(light), .faces = {}, .c_bias = proto.c_bias()};
  if (proto.has_c_scale()) map.c_scale = proto.c_scale();
  for (int i = 0; i < proto.faces_size(); ++i) {
    auto face = Read(proto.faces(i), "shadow_width_map.faces[" + std::to_string(i) + "]", limits);
    if (!face.ok()) return face.status();
    map.faces.push_back(*std::move(face));
  }
  if (status = CheckTexels(map, limits); !status.ok()) return status;
  return map;
}

}  // namespace penumbra
