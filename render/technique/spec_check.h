// What techniques ask of a spec, and say of it, in the same way.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "render/artifact/artifact.h"
#include "render/scene/scene.h"
#include "render/technique/artifact_spec.h"

namespace penumbra {

// Of a technique that takes one light at a time.
//
// Errors  kNotFound UNKNOWN_ID, kInvalidArgument RANGE for all lights at once; at "light_id"
absl::Status CheckOneLight(const Scene& scene, const std::string& light_id);

// The same error, its field, if it names one, put within `path`: "layered_attenuation.".
absl::Status Within(std::string_view path, const absl::Status& status);

// What an artifact's header says of the scene and the spec; parameters are the technique's to say.
ArtifactHeader HeaderOf(const Scene& scene, const ArtifactSpec& spec);

}  // namespace penumbra
