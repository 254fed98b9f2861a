// The values of single options, read from text. Errors are kInvalidArgument with the option as the
// field path.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/cli/commands.h"
#include "client/cli/light_option.h"

namespace penumbra {

// The parameters, at their defaults, of the technique called `text`.
absl::StatusOr<TechniqueParams> ReadTechnique(std::string_view option, std::string_view text);
absl::Status SetSamples(TechniqueParams& params, std::string_view text);
// --min-area in m², 0 or more; --texels-per-metre, above 0 and at most 1e6.
absl::Status SetArea(std::string_view text, double& area_m2);
absl::Status SetDensity(std::string_view text, float& texels_per_metre);
absl::Status SetSeed(TechniqueParams& params, std::string_view text);
absl::Status SetTimeBudget(std::string_view text, float& time_budget_ms);
absl::Status SetSeconds(std::string_view text, double& seconds);    // > 0
absl::Status SetUpdates(std::string_view text, uint64_t& updates);  // > 0
// Anything with a port, or of the scheme unix:; gRPC reads the rest.
absl::Status SetServer(std::string_view text, std::string& server);
absl::Status SetSceneId(std::string_view option, std::string_view text, std::string& scene_id);
// From 0 on.
absl::Status SetCount(std::string_view option, std::string_view text, uint32_t& count);
absl::Status SetRevision(std::string_view option, std::string_view text,
                         std::optional<uint64_t>& revision);
// Within the two; a number in any case.
absl::Status SetWithin(std::string_view option, std::string_view text, double least, double most,
                       double& value);
absl::Status SetMethod(TechniqueParams& params, std::string_view text);

// Ids are the option's, with "-2", "-3", … after the first of its kind. Lights and receivers that
// no scene would take are errors as well.
absl::Status AddLight(const LightOption& option, std::string_view text,
                      std::vector<AreaLight>& lights);
absl::Status AddReceiver(std::string_view text, std::vector<Parallelogram>& receivers);

absl::StatusOr<GridSize> ReadTexels(std::string_view option, std::string_view text);
absl::StatusOr<GridSize> ReadPixels(std::string_view option, std::string_view text);
// Four whole numbers, of which the last two are above 0.
absl::StatusOr<PixelRect> ReadRect(std::string_view option, std::string_view text);

// Three numbers, or one for all three.
absl::Status SetAmbient(std::string_view text, std::optional<Vec3>& ambient);          // ≥ 0
absl::StatusOr<Vec3> ReadReflectance(std::string_view option, std::string_view text);  // in [0, 1]

absl::Status SetExposure(std::string_view text, std::optional<float>& exposure);  // > 0
absl::Status SetVolumeShading(std::string_view text, VolumeShading& shading);
absl::Status SetVolumeOpacity(std::string_view text, float& opacity);  // in [0, 1]
absl::Status SetVolumePasses(std::string_view text, int& passes);      // 1 to kMaxVolumePasses
// "#3366ff" or "3366ff", as 0xRRGGBB.
absl::StatusOr<uint32_t> ReadColour(std::string_view option, std::string_view text);
absl::Status SetCamera(std::string_view text, std::optional<Camera>& camera);

}  // namespace penumbra
