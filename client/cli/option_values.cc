#include "client/cli/option_values.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client/cli/fitting_options.h"
#include "client/cli/option_error.h"
#include "client/cli/parameter_option.h"
#include "render/scene/field_error.h"
#include "render/scene/scene.h"
#include "render/scene/scene_check.h"
#include "render/scene/scene_limits.h"
#include "render/scene/texture_size.h"

namespace penumbra {
namespace {

// The largest texture that Mesa's software device draws into.
constexpr uint32_t kMaxPictureSide = 16'384;

absl::Status RangeError(std::string_view option, std::string_view text, std::string_view need) {
  return OptionError(option, "RANGE", {text}, absl::StrCat(", need ", std::string(need)));
}

std::string OneOf(std::span<const std::string_view> names) {
  const std::vector<std::string> all(names.begin(), names.end());
  return absl::StrCat("one of: ", absl::StrJoin(all, ", "));
}

absl::Status CountError(std::string_view option, size_t found, std::string_view need) {
  return FieldError(absl::StatusCode::kInvalidArgument, "NUMBER_COUNT", option,
                    absl::StrCat("found ", found, " numbers, need ", std::string(need)));
}

// One number for which `is_right`.
absl::StatusOr<float> ReadNumber(std::string_view option, std::string_view text,
                                 bool (*is_right)(float), std::string_view need) {
  const auto numbers = ParseNumbers(option, text);
  if (!numbers.ok()) return numbers.status();
  if (numbers->size() != 1 || !is_right((*numbers)[0])) return RangeError(option, text, need);
  return (*numbers)[0];
}

absl::StatusOr<float> ReadPositive(std::string_view option, std::string_view text) {
  return ReadNumber(
      option, text, [](float x) { return x > 0.0f; }, "one number above 0");
}

template <typename T>
absl::Status Set(const absl::StatusOr<float>& number, T& value) {
  if (number.ok()) value = *number;
  return number.status();
}

absl::StatusOr<Vec3> ReadColor(std::string_view option, std::string_view text, float max) {
  const auto numbers = ParseNumbers(option, text);
  if (!numbers.ok()) return numbers.status();
  if (numbers->size() != 1 && numbers->size() != 3) {
    return CountError(option, numbers->size(), "1 or 3");
  }
  const auto in_range = [max](float x) { return x >= 0.0f && x <= max; };
  if (!std::ranges::all_of(*numbers, in_range)) {
    return RangeError(option, text, max == 1.0f ? "0 to 1" : "0 or more");
  }
  return numbers->size() == 1 ? Vec3((*numbers)[0]) : Vec3At(*numbers, 0);
}

}  // namespace

absl::StatusOr<TechniqueParams> ReadTechnique(std::string_view option, std::string_view text) {
  std::vector<std::string> names;
  for (const TechniqueParams& params : AllTechniques()) {
    if (InfoOf(params).name == text) return params;
    names.emplace_back(InfoOf(params).name);
  }
  return OptionError(option, "UNKNOWN_TECHNIQUE", {text},
                     absl::StrCat(", need one of: ", absl::StrJoin(names, ", ")));
}

absl::Status SetSamples(TechniqueParams& params, std::string_view text) {
  const auto samples = ReadInteger<uint32_t>(text);
  if (!samples) return RangeError("--samples", text, "a whole number");
  return std::visit(
      [&](auto& p) {
        if constexpr (requires { p.samples; }) {
          p.samples = *samples;
          return absl::OkStatus();
        } else {
          return TechniqueConflict("--samples", params, "one that samples the light");
        }
      },
      params);
}

absl::Status SetSeed(TechniqueParams& params, std::string_view text) {
  const auto seed = ReadInteger<uint64_t>(text);
  if (!seed) return RangeError("--seed", text, "a whole number of 64 bits");
  return std::visit(
      [&](auto& p) {
        if constexpr (requires { p.seed; }) {
          p.seed = *seed;
          return absl::OkStatus();
        } else {
          return TechniqueConflict("--seed", params, "one that samples the light");
        }
      },
      params);
}

absl::Status SetTimeBudget(std::string_view text, float& time_budget_ms) {
  return Set(ReadPositive("--time-budget", text), time_budget_ms);
}

absl::Status SetSeconds(std::string_view text, double& seconds) {
  return Set(ReadPositive("--seconds", text), seconds);
}

absl::Status SetUpdates(std::string_view text, uint64_t& updates) {
  const auto number = ReadInteger<uint64_t>(text);
  if (!number || *number == 0) return RangeError("--updates", text, "a whole number above 0");
  updates = *number;
  return absl::OkStatus();
}

absl::Status SetMethod(TechniqueParams& params, std::string_view text) {
  const auto method = VisibilityMethodNamed(text);
  if (!method) {
    return RangeError("--method", text, OneOf(kVisibilityMethodNames));
  }
  const auto soft_texture = OfSoftTexture("--method", params);
  if (soft_texture.ok()) (*soft_texture)->method = *method;
  return soft_texture.status();
}

absl::Status AddLight(const LightOption& option, std::string_view text,
                      std::vector<AreaLight>& lights) {
  auto shape = ParseLight(option, text);
  if (!shape.ok()) return shape.status();
  if (auto status = CheckAngles(option, *shape); !status.ok()) return status;
  const auto is_same_kind = [&](const AreaLight& light) { return light.id.starts_with(option.id); };
  const auto before = std::ranges::count_if(lights, is_same_kind);
  std::string id = before == 0 ? option.id : absl::StrCat(option.id, "-", before + 1);
  AreaLight light{.id = std::move(id), .shape = *std::move(shape)};
  if (auto status = CheckLight(light, option.name, SceneLimits{}); !status.ok()) return status;
  lights.push_back(std::move(light));
  return absl::OkStatus();
}

absl::Status AddReceiver(std::string_view text, std::vector<Parallelogram>& receivers) {
  const auto numbers = ParseNumbers("--receiver", text);
  if (!numbers.ok()) return numbers.status();
  if (numbers->size() != 9) {
    return CountError("--receiver", numbers->size(), "9: origin edge_u edge_v");
  }
  const Parallelogram patch{Vec3At(*numbers, 0), Vec3At(*numbers, 3), Vec3At(*numbers, 6)};
  const Receiver receiver{.id = "receiver", .shape = patch, .width = 1, .height = 1};
  if (auto status = CheckReceiver(receiver, "--receiver", SceneLimits{}); !status.ok()) {
    return status;
  }
  receivers.push_back(patch);
  return absl::OkStatus();
}

absl::StatusOr<GridSize> ReadTexels(std::string_view option, std::string_view text) {
  return ParseSize(option, text, SceneLimits{}.max_receiver_side);
}

absl::StatusOr<GridSize> ReadPixels(std::string_view option, std::string_view text) {
  return ParseSize(option, text, kMaxPictureSide);
}

absl::StatusOr<Vec3> ReadReflectance(std::string_view option, std::string_view text) {
  return ReadColor(option, text, 1.0f);
}

absl::Status SetAmbient(std::string_view text, std::optional<Vec3>& ambient) {
  const auto color = ReadColor("--ambient", text, std::numeric_limits<float>::max());
  if (color.ok()) ambient = *color;
  return color.status();
}

absl::Status SetArea(std::string_view text, double& area_m2) {
  const auto is_right = [](float x) { return x >= 0.0f && x <= 1e18f; };
  return Set(ReadNumber("--min-area", text, is_right, "one number, 0 to 1e18"), area_m2);
}

absl::Status SetDensity(std::string_view text, float& texels_per_metre) {
  const auto is_right = [](float x) { return x > 0.0f && x <= kMaxTexelsPerMetre; };
  return Set(ReadNumber("--texels-per-metre", text, is_right, "one number above 0, at most 1e6"),
             texels_per_metre);
}

absl::Status SetExposure(std::string_view text, std::optional<float>& exposure) {
  return Set(ReadPositive("--exposure", text), exposure);
}

absl::Status SetVolumeShading(std::string_view text, VolumeShading& shading) {
  const auto name = std::ranges::find(kVolumeShadingNames, text);
  if (name == kVolumeShadingNames.end()) {
    return RangeError("--volume-shading", text, OneOf(kVolumeShadingNames));
  }
  shading = static_cast<VolumeShading>(name - kVolumeShadingNames.begin());
  return absl::OkStatus();
}

absl::Status SetVolumeOpacity(std::string_view text, float& opacity) {
  return Set(ReadNumber(
                 "--volume-opacity", text, [](float x) { return x >= 0 && x <= 1; },
                 "a number from 0 to 1"),
             opacity);
}

absl::Status SetVolumePasses(std::string_view text, int& passes) {
  const auto number = ReadInteger<uint32_t>(text);
  if (!number || *number < 1 || *number > uint32_t{kMaxVolumePasses}) {
    return RangeError("--volume-passes", text, absl::StrCat("1 to ", kMaxVolumePasses));
  }
  passes = static_cast<int>(*number);
  return absl::OkStatus();
}

absl::StatusOr<PixelRect> ReadRect(std::string_view option, std::string_view text) {
  const auto numbers = ParseNumbers(option, text);
  if (!numbers.ok()) return numbers.status();
  const auto is_whole = [](float x) { return x >= 0 && x <= 1 << 20 && x == std::floor(x); };
  if (numbers->size() != 4 || !std::ranges::all_of(*numbers, is_whole) || !((*numbers)[2] > 0) ||
      !((*numbers)[3] > 0)) {
    return RangeError(option, text, "x y width height in whole pixels");
  }
  const auto at = [&](size_t i) { return static_cast<uint32_t>((*numbers)[i]); };
  return PixelRect{at(0), at(1), at(2), at(3)};
}

absl::StatusOr<uint32_t> ReadColour(std::string_view option, std::string_view text) {
  const std::string_view digits = text.substr(text.starts_with('#') ? 1 : 0);
  uint32_t rgb = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), rgb, 16);
  if (digits.size() != 6 || error != std::errc() || end != digits.data() + digits.size()) {
    return RangeError(option, text, "six hexadecimal digits, RRGGBB");
  }
  return rgb;
}

absl::Status SetCamera(std::string_view text, std::optional<Camera>& camera) {
  const auto numbers = ParseNumbers("--camera", text);
  if (!numbers.ok()) return numbers.status();
  const size_t count = numbers->size();
  if (count != 6 && count != 7 && count != 9 && count != 10) {
    return CountError("--camera", count, "6, 7, 9 or 10: eye target [up] [fov_deg]");
  }
  Camera choice{.eye = Vec3At(*numbers, 0), .target = Vec3At(*numbers, 3)};
  if (count >= 9) choice.up = Vec3At(*numbers, 6);
  if (count == 7 || count == 10) choice.fov_y_deg = numbers->back();
  if (choice.target == choice.eye)
    return RangeError("--camera", text, "a target apart from the eye");
  if (choice.up == Vec3(0.0f)) return RangeError("--camera", text, "an up that is not 0");
  if (!(choice.fov_y_deg > 0.0f && choice.fov_y_deg < 180.0f)) {
    return RangeError("--camera", text, "a field of view above 0 and below 180 degrees");
  }
  camera = choice;
  return absl::OkStatus();
}

}  // namespace penumbra
