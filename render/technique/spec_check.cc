#include "render/technique/spec_check.h"

#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"

namespace penumbra {

absl::Status CheckOneLight(const Scene& scene, const std::string& light_id) {
  if (light_id == kAllLights) {
    return FieldError(absl::StatusCode::kInvalidArgument, "RANGE", "light_id",
                      "found *, need one light at a time");
  }
  if (scene.FindLight(light_id)) return absl::OkStatus();
  return FieldError(absl::StatusCode::kNotFound, "UNKNOWN_ID", "light_id",
                    absl::StrCat("found ", light_id, ", need a light of the scene"));
}

absl::Status Within(std::string_view path, const absl::Status& status) {
  return ErrorFieldPath(status).empty() ? status : WithFieldPrefix(status, path);
}

ArtifactHeader HeaderOf(const Scene& scene, const ArtifactSpec& spec) {
  return {.scene_id = scene.id(),
          .revision = scene.revision(),
          .scene_hash = scene.content_hash(),
          .technique = std::string(InfoOf(spec.params).name),
          .light_id = spec.light_id,
          .receiver_id = spec.receiver_id};
}

}  // namespace penumbra
