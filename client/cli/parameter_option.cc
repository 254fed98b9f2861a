#include "client/cli/parameter_option.h"

#include <array>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client/cli/fitting_options.h"
#include "client/cli/numbers.h"
#include "client/cli/option_error.h"
#include "client/cli/option_values.h"
#include "client/cli/shading_options.h"

namespace penumbra {
namespace {

// Errors of values have the field path that SetParameter gives them.
constexpr std::string_view kAnyField = "value";

absl::Status RangeError(std::string_view text, const std::string& need) {
  return OptionError(kAnyField, "RANGE", {text}, absl::StrCat(", need ", need));
}

template <typename Integer>
absl::Status SetInteger(std::string_view text, Integer& value) {
  const auto number = ReadInteger<Integer>(text);
  if (!number) return RangeError(text, "a whole number");
  value = *number;
  return absl::OkStatus();
}

absl::Status Set(std::string_view text, uint32_t& value) { return SetInteger(text, value); }
absl::Status Set(std::string_view text, uint64_t& value) { return SetInteger(text, value); }

absl::Status Set(std::string_view text, bool& value) {
  if (text != "true" && text != "false") return RangeError(text, "true or false");
  value = text == "true";
  return absl::OkStatus();
}

absl::Status Set(std::string_view text, float& value) {
  const auto numbers = ParseNumbers(kAnyField, text);
  if (!numbers.ok()) return numbers.status();
  if (numbers->size() != 1) return RangeError(text, "one number");
  value = numbers->front();
  return absl::OkStatus();
}

template <typename Enum>
absl::Status SetNamed(std::string_view text, std::span<const std::string_view> names, Enum& value) {
  for (size_t i = 0; i < names.size(); ++i) {
    if (names[i] != text) continue;
    value = static_cast<Enum>(i);
    return absl::OkStatus();
  }
  const std::vector<std::string> all(names.begin(), names.end());
  return RangeError(text, absl::StrCat("one of: ", absl::StrJoin(all, ", ")));
}

absl::Status Set(std::string_view text, DepthMethod& value) {
  return SetNamed(text, kDepthMethodNames, value);
}
absl::Status Set(std::string_view text, DistanceMethod& value) {
  return SetNamed(text, kDistanceMethodNames, value);
}
absl::Status Set(std::string_view text, BlockerDepth& value) {
  return SetNamed(text, kBlockerDepthNames, value);
}
absl::Status Set(std::string_view text, VolumeSurface& value) {
  return SetNamed(text, kVolumeSurfaceNames, value);
}
absl::Status Set(std::string_view text, VolumesOf& value) {
  return SetNamed(text, kVolumesOfNames, value);
}
absl::Status Set(std::string_view text, RayBackend& value) {
  return SetNamed(text, kRayBackendNames, value);
}
absl::Status Set(std::string_view text, RadianceFormat& value) {
  return SetNamed(text, kRadianceFormatNames, value);
}

// One parameter of a technique.
template <typename Params>
struct Parameter {
  std::string_view name;
  absl::Status (*set)(Params& params, std::string_view text);
};

template <typename Params, auto kMember>
constexpr Parameter<Params> Of(std::string_view name) {
  return {name, [](Params& params, std::string_view text) { return Set(text, params.*kMember); }};
}

using Layered = LayeredAttenuationParams;
constexpr Parameter<Layered> kLayered[] = {
    Of<Layered, &Layered::samples>("samples"),       Of<Layered, &Layered::seed>("seed"),
    Of<Layered, &Layered::resolution>("resolution"), Of<Layered, &Layered::tolerance>("tolerance"),
    Of<Layered, &Layered::source>("source"),         Of<Layered, &Layered::key_views>("key_views"),
    Of<Layered, &Layered::max_layers>("max_layers"),
};

using Coherent = CoherentRaytraceParams;
constexpr Parameter<Coherent> kCoherent[] = {
    Of<Coherent, &Coherent::samples>("samples"),
    Of<Coherent, &Coherent::seed>("seed"),
    Of<Coherent, &Coherent::backend>("backend"),
    Of<Coherent, &Coherent::radiance>("radiance"),
    Of<Coherent, &Coherent::output>("output"),
    Of<Coherent, &Coherent::coherence>("coherence"),
    Of<Coherent, &Coherent::whole_light>("whole_light"),
    Of<Coherent, &Coherent::ray_accelerations>("ray_accelerations"),
    Of<Coherent, &Coherent::prediction_distance>("prediction_distance"),
    Of<Coherent, &Coherent::resolution>("resolution"),
    Of<Coherent, &Coherent::gap_bias>("gap_bias"),
    Of<Coherent, &Coherent::shadow_bias>("shadow_bias"),
};

using Width = ShadowWidthParams;
constexpr Parameter<Width> kWidth[] = {
    Of<Width, &Width::resolution>("resolution"), Of<Width, &Width::distance>("distance"),
    Of<Width, &Width::layers>("layers"),         Of<Width, &Width::blocker_depth>("blocker_depth"),
    Of<Width, &Width::c_scale>("c_scale"),       Of<Width, &Width::c_bias>("c_bias"),
    Of<Width, &Width::source>("source"),
};

using Volume = ShadowVolumeParams;
constexpr Parameter<Volume> kVolume[] = {
    Of<Volume, &Volume::resolution>("resolution"),
    Of<Volume, &Volume::bias>("bias"),
    Of<Volume, &Volume::low_threshold>("low_threshold"),
    Of<Volume, &Volume::high_threshold>("high_threshold"),
    Of<Volume, &Volume::surface>("surface"),
    Of<Volume, &Volume::volumes_of>("volumes_of"),
    Of<Volume, &Volume::object_ids>("object_ids"),
    Of<Volume, &Volume::source>("source"),
};

struct Unknown {};

// A status, or that there is no such parameter.
using Outcome = std::variant<Unknown, absl::Status>;

template <typename Params, size_t kCount>
Outcome SetOneOf(const Parameter<Params> (&parameters)[kCount], Params& params,
                 std::string_view name, std::string_view value) {
  for (const auto& parameter : parameters) {
    if (parameter.name == name) return parameter.set(params, value);
  }
  return Unknown{};
}

Outcome SetOf(LayeredAttenuationParams& params, TechniqueParams&, std::string_view name,
              std::string_view value) {
  return SetOneOf(kLayered, params, name, value);
}

Outcome SetOf(CoherentRaytraceParams& params, TechniqueParams&, std::string_view name,
              std::string_view value) {
  return SetOneOf(kCoherent, params, name, value);
}

Outcome SetOf(ShadowWidthParams& params, TechniqueParams&, std::string_view name,
              std::string_view value) {
  return SetOneOf(kWidth, params, name, value);
}

Outcome SetOf(ShadowVolumeParams& params, TechniqueParams&, std::string_view name,
              std::string_view value) {
  return SetOneOf(kVolume, params, name, value);
}

// Each of its parameters has an option of its own.
Outcome SetOf(SoftTextureParams& params, TechniqueParams& all, std::string_view name,
              std::string_view value) {
  if (name == "samples") return Set(value, params.samples);
  if (name == "seed") return Set(value, params.seed);
  if (name == "radiance") return Set(value, params.radiance);
  if (name == "method") return SetMethod(all, value);
  std::string option =
      absl::StrCat("--", std::string(name == "ambient" ? "ambient_radiance" : name));
  for (char& c : option) c = c == '_' ? '-' : c;
  for (const ShadingOption& known : ShadingOptions()) {
    if (known.name == option) return known.set(all, value);
  }
  return Unknown{};
}

}  // namespace

absl::Status SetParameter(std::string_view option, TechniqueParams& params, std::string_view text) {
  const size_t equals = text.find('=');
  if (equals == std::string_view::npos) {
    return OptionError(option, "FORMAT", {text}, ", need NAME=VALUE");
  }
  const std::string_view name = text.substr(0, equals), value = text.substr(equals + 1);
  const Outcome outcome =
      std::visit([&](auto& own) { return SetOf(own, params, name, value); }, params);
  if (const auto* status = std::get_if<absl::Status>(&outcome)) {
    return status->ok()
               ? *status
               : OfOption(absl::StrCat(std::string(option), " ", std::string(name)), *status);
  }
  std::vector<std::string> known;
  for (const ParameterInfo& parameter : InfoOf(params).parameters) {
    known.emplace_back(parameter.name);
  }
  return OptionError(option, "UNKNOWN_PARAMETER", {name},
                     absl::StrCat(", need one of ", std::string(InfoOf(params).name),
                                  "'s: ", absl::StrJoin(known, ", ")));
}

absl::StatusOr<SoftTextureParams*> OfSoftTexture(std::string_view option, TechniqueParams& params) {
  if (auto* own = std::get_if<SoftTextureParams>(&params)) return own;
  return TechniqueConflict(option, params, SoftTextureParams::kInfo.name);
}

}  // namespace penumbra
