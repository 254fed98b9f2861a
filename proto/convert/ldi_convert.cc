#include "proto/convert/ldi_convert.h"

#include <cmath>
#include <string>
#include <utility>

#include "proto/convert/light_convert.h"
#include "proto/convert/view_convert.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

absl::Status Invalid(const char* reason, const std::string& field, const std::string& text) {
  return FieldError(absl::StatusCode::kInvalidArgument, reason, field, text);
}

}  // namespace

v1::AttenuationLdi ToProto(const AttenuationLdi& ldi) {
  v1::AttenuationLdi proto;
  *proto.mutable_light() = ToProto(ldi.light);
  proto.set_sample_count(ldi.sample_count);
  proto.set_tolerance(ldi.tolerance);
  for (const LdiFace& face : ldi.faces) *proto.add_faces() = ToProto(face.view);
  return proto;
}

absl::StatusOr<AttenuationLdi> FromProto(const v1::AttenuationLdi& proto,
                                         const SceneLimits& limits) {
  auto light = FromProto(proto.light(), "attenuation_ldi.light");
  if (!light.ok()) return light.status();
  if (proto.sample_count() < 1 || proto.sample_count() > UINT16_MAX) {
    return Invalid("RANGE", "attenuation_ldi.sample_count",
                   "found " + std::to_string(proto.sample_count()) + ", need 1 to 65535");
  }
  if (!(std::isfinite(proto.tolerance()) && proto.tolerance() > 0)) {
    return Invalid("RANGE", "attenuation_ldi.tolerance",
                   "found " + std::to_string(proto.tolerance()) + ", need a number above 0");
  }
  if (auto status = CheckFaceCount(proto.faces_size(), "attenuation_ldi.faces"); !status.ok()) {
    return status;
  }
  AttenuationLdi ldi{.light = *std::move(light),
                     .faces = {},
                     .sample_count = proto.sample_count(),
                     .tolerance = proto.tolerance()};
  for (int i = 0; i < proto.faces_size(); ++i) {
    LdiFace face{.view = FromProto(proto.faces(i)), .offsets = {}, .depths = {}, .counts = {}};
    const std::string field = "attenuation_ldi.faces[" + std::to_string(i) + "]";
    if (auto status = CheckView(face.view, field, limits); !status.ok()) return status;
    ldi.faces.push_back(std::move(face));
  }
  return ldi;
}

}  // namespace penumbra
