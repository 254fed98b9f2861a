#include "client/cli/fitting_options.h"

#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

absl::Status CheckNamesNoReceiver(const ShadowRequest& request) {
  const std::pair<std::string_view, bool> options[] = {
      {"--receiver", !request.receivers.empty()},
      {"--receiver-instance", !request.receiver_instances.empty()},
      {"--every-polygon", request.every_polygon},
  };
  for (const auto& [option, is_given] : options) {
    if (is_given) return TechniqueConflict(option, request.params, "soft_texture");
  }
  return absl::OkStatus();
}

absl::Status CheckNamesNoPoints(const ShadowRequest& request) {
  const PointRequest& points = request.points;
  const std::pair<std::string_view, bool> options[] = {
      {"--lightmap", !points.lightmaps.empty()}, {"--points", !points.file.empty()},
      {"--camera", points.camera.has_value()},   {"--picture", points.picture.has_value()},
      {"--crop", !points.crop.empty()},          {"--first", !points.first.empty()},
  };
  for (const auto& [option, is_given] : options) {
    if (is_given) return TechniqueConflict(option, request.params, "coherent_raytrace");
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status TechniqueConflict(std::string_view option, const TechniqueParams& params,
                               std::string_view need) {
  return FieldError(absl::StatusCode::kInvalidArgument, "CONFLICT", option,
                    absl::StrCat("found the technique ", std::string(InfoOf(params).name),
                                 ", which has no use for it, need ", std::string(need)));
}

absl::Status CheckOptionsFit(const ShadowRequest& request) {
  const SpecTarget target = InfoOf(request.params).target;
  if (target != SpecTarget::kReceiver) {
    if (auto status = CheckNamesNoReceiver(request); !status.ok()) return status;
  }
  if (target != SpecTarget::kPoints) {
    if (auto status = CheckNamesNoPoints(request); !status.ok()) return status;
  }
  if (!request.texels) return absl::OkStatus();
  if (target == SpecTarget::kScene) {
    return TechniqueConflict(request.texels_option, request.params, "--set resolution=PIXELS");
  }
  if (target == SpecTarget::kPoints && request.points.lightmaps.empty()) {
    return TechniqueConflict(request.texels_option, request.params,
                             "an option for the picture's size, or a lightmap");
  }
  return absl::OkStatus();
}

}  // namespace penumbra
