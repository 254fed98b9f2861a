#include "proto/convert/volume_convert.h"

#include <string>
#include <utility>

#include "proto/convert/light_convert.h"
#include "render/scene/field_error.h"
#include "render/technique/technique_params.h"

namespace penumbra {
namespace {

absl::Status CheckNumber(const char* field, float found, float most) {
  if (found >= 0 && found <= most) return absl::OkStatus();
  return FieldError(absl::StatusCode::kInvalidArgument, "RANGE", field,
                    "found " + std::to_string(found) + ", need 0 to " + std::to_string(most));
}

}  // namespace

v1::ShadowVolumeMesh ToProto(const ShadowVolumeMesh& mesh) {
  v1::ShadowVolumeMesh proto;
  *proto.mutable_light() = ToProto(mesh.light);
  proto.set_bias_px(mesh.bias_px);
  proto.set_edge_fraction(mesh.edge_fraction);
  return proto;
}

absl::StatusOr<ShadowVolumeMesh> FromProto(const v1::ShadowVolumeMesh& proto) {
  auto light = FromProto(proto.light(), "shadow_volume_mesh.light");
  if (!light.ok()) return light.status();
  absl::Status status = CheckNumber("shadow_volume_mesh.bias_px", proto.bias_px(), kMaxVolumeBias);
  status.Update(CheckNumber("shadow_volume_mesh.edge_fraction", proto.edge_fraction(), 1.0f));
  if (!status.ok()) return status;
  return ShadowVolumeMesh{.light = *std::move(light),
                          .bias_px = proto.bias_px(),
                          .volumes = {},
                          .edge_fraction = proto.edge_fraction()};
}

}  // namespace penumbra
