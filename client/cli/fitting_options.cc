#include "client/cli/fitting_options.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "client/cli/option_error.h"
#include "render/scene/field_error.h"
#include "render/technique/artifact_spec.h"

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

// Rays find what the eye meets first, whichever side it shows.
absl::Status CheckCulling(const ViewCommand& command) {
  const TechniqueParams& params = command.request.params;
  const bool is_traced = InfoOf(params).target == SpecTarget::kPoints;
  if (!command.culls_back_faces || !(is_traced || command.final)) return absl::OkStatus();
  const std::string traced =
      is_traced ? absl::StrCat("--technique ", std::string(InfoOf(params).name)) : "--final";
  return FieldError(absl::StatusCode::kInvalidArgument, "CONFLICT", "--cull-back-faces",
                    absl::StrCat("found with ", traced,
                                 ", whose shadows are on the faces that are left out, need one of "
                                 "the two (with a --camera inside of the room, ",
                                 traced, " alone)"));
}

absl::Status CheckVolumeLook(const ViewCommand& command) {
  const VolumeShading shading = command.volume_look.value_or(VolumeLook{}).shading;
  if (!command.has_volume_opacity || shading == VolumeShading::kComposited) return absl::OkStatus();
  const std::string name(kVolumeShadingNames[static_cast<size_t>(shading)]);
  return FieldError(absl::StatusCode::kInvalidArgument, "CONFLICT", "--volume-opacity",
                    absl::StrCat("found with --volume-shading ", name,
                                 ", which has no use for it, need --volume-shading composited"));
}

}  // namespace

absl::Status TechniqueConflict(std::string_view option, const TechniqueParams& params,
                               std::string_view need) {
  return FieldError(absl::StatusCode::kInvalidArgument, "CONFLICT", option,
                    absl::StrCat("found the technique ", std::string(InfoOf(params).name),
                                 ", which has no use for it, need ", std::string(need)));
}

absl::Status CheckLightsFit(const std::vector<std::string>& light_ids,
                            const TechniqueParams& params) {
  const bool asks_for_sum = std::ranges::count(light_ids, kAllLights) > 0;
  if (!asks_for_sum || std::holds_alternative<SoftTextureParams>(params)) return absl::OkStatus();
  return OptionError("--light", "CONFLICT", {kAllLights},
                     absl::StrCat(", which is all lights in one, and the technique ",
                                  std::string(InfoOf(params).name),
                                  " takes one light at a time, need names, or no --light for each "
                                  "of them"));
}

absl::Status CheckOptionsFit(const ViewCommand& command) {
  const TechniqueParams& params = command.request.params;
  const SpecTarget target = InfoOf(params).target;
  if (command.max_planar_receivers && target != SpecTarget::kReceiver) {
    return TechniqueConflict("--receivers", params, "soft_texture");
  }
  if (command.has_final_settings && target == SpecTarget::kPoints) {
    return TechniqueConflict("--final-set", params, "--set");
  }
  if (command.volume_look && !std::holds_alternative<ShadowVolumeParams>(params)) {
    return TechniqueConflict(command.volume_option, params, ShadowVolumeParams::kInfo.name);
  }
  absl::Status status = CheckVolumeLook(command);
  if (status.ok()) status = CheckCulling(command);
  return status.ok() ? CheckOptionsFit(command.request) : status;
}

absl::Status CheckOptionsFit(const ShadowRequest& request) {
  const SpecTarget target = InfoOf(request.params).target;
  if (request.adds_up_lights) {
    if (auto status = CheckLightsFit(request.light_ids, request.params); !status.ok()) {
      return status;
    }
  }
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
