#include "client/cli/shading_options.h"

#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client/cli/numbers.h"
#include "client/cli/option_error.h"
#include "client/cli/parameter_option.h"

namespace penumbra {
namespace {

absl::Status RangeError(std::string_view option, std::string_view text, const std::string& need) {
  return OptionError(option, "RANGE", {text}, absl::StrCat(", need ", need));
}

// The place of `text` among `names`, as the value of an enumeration in the same order.
template <typename Enum, size_t kCount>
absl::Status SetNamed(std::string_view option, const std::array<std::string_view, kCount>& names,
                      std::string_view text, Enum& value) {
  for (size_t i = 0; i < kCount; ++i) {
    if (names[i] != text) continue;
    value = static_cast<Enum>(i);
    return absl::OkStatus();
  }
  const std::array<std::string_view, kCount>& all = names;
  const auto append = [](std::string* out, std::string_view name) { out->append(name); };
  return RangeError(option, text, absl::StrCat("one of: ", absl::StrJoin(all, ", ", append)));
}

absl::Status SetNumber(std::string_view option, std::string_view text, float most, float& value) {
  const auto numbers = ParseNumbers(option, text);
  if (!numbers.ok()) return numbers.status();
  if (numbers->size() != 1 || !((*numbers)[0] >= 0 && (*numbers)[0] <= most)) {
    return RangeError(option, text, absl::StrCat("one number from 0 to ", most));
  }
  value = (*numbers)[0];
  return absl::OkStatus();
}

absl::Status SetReuse(std::string_view text, uint32_t& value) {
  float number = 0;
  const auto status = SetNumber("--silhouette-reuse", text, kMaxSilhouetteReuse, number);
  if (!status.ok()) return status;
  if (number < 1 || number != std::floor(number)) {
    return RangeError("--silhouette-reuse", text,
                      absl::StrCat("a whole number from 1 to ", kMaxSilhouetteReuse));
  }
  value = static_cast<uint32_t>(number);
  return absl::OkStatus();
}

absl::Status SetAmbient(std::string_view option, std::string_view text, Vec3& value) {
  const auto numbers = ParseNumbers(option, text);
  if (!numbers.ok()) return numbers.status();
  if (numbers->size() != 1 && numbers->size() != 3) {
    return RangeError(option, text, "1 or 3 numbers");
  }
  for (const float number : *numbers) {
    if (!(number >= 0)) return RangeError(option, text, "numbers of at least 0");
  }
  value = numbers->size() == 1 ? Vec3((*numbers)[0]) : Vec3At(*numbers, 0);
  return absl::OkStatus();
}

// Sets a member of soft_texture's parameters by `set(value)`. Those about radiance ask for it too.
template <typename T, typename SetIt>
absl::Status SetOfSoftTexture(std::string_view option, TechniqueParams& params,
                              T SoftTextureParams::*member, bool of_radiance, SetIt set) {
  const auto soft_texture = OfSoftTexture(option, params);
  if (!soft_texture.ok()) return soft_texture.status();
  if (of_radiance) (*soft_texture)->radiance = true;
  return set((*soft_texture)->*member);
}

constexpr ShadingOption kOptions[] = {
    {"--shading", "NAME",
     "How radiance is made: product, or sample_sum, which is right for large lights too (default "
     "product)",
     [](TechniqueParams& params, std::string_view text) {
       return SetOfSoftTexture(
           "--shading", params, &SoftTextureParams::shading, true,
           [&](Shading& value) { return SetNamed("--shading", kShadingNames, text, value); });
     }},
    {"--form-factor-error", "SHARE",
     "Bound on the relative error of unoccluded light; 0: closed form everywhere (default 0.001)",
     [](TechniqueParams& params, std::string_view text) {
       return SetOfSoftTexture("--form-factor-error", params, &SoftTextureParams::form_factor_error,
                               true, [&](float& value) {
                                 return SetNumber("--form-factor-error", text, kMaxFormFactorError,
                                                  value);
                               });
     }},
    {"--ambient-radiance", "\"r g b\"", "Radiance that reaches every texel (default 0)",
     [](TechniqueParams& params, std::string_view text) {
       return SetOfSoftTexture(
           "--ambient-radiance", params, &SoftTextureParams::ambient, true,
           [&](Vec3& value) { return SetAmbient("--ambient-radiance", text, value); });
     }},
    {"--output", "NAME",
     "What radiance is rounded to: float32, half, unorm16 or unorm8 (default float32)",
     [](TechniqueParams& params, std::string_view text) {
       return SetOfSoftTexture("--output", params, &SoftTextureParams::output, true,
                               [&](RadianceFormat& value) {
                                 return SetNamed("--output", kRadianceFormatNames, text, value);
                               });
     }},
    {"--output-scale", "RADIANCE",
     "What 1 is in unorm outputs (default: the most that the texture has with nothing in the way)",
     [](TechniqueParams& params, std::string_view text) {
       return SetOfSoftTexture(
           "--output-scale", params, &SoftTextureParams::output_scale, true,
           [&](float& value) { return SetNumber("--output-scale", text, kMaxOutputScale, value); });
     }},
    {"--silhouette-reuse", "N",
     "Light samples that share one's outlines of meshes: quicker, and no longer exact (default 1)",
     [](TechniqueParams& params, std::string_view text) {
       return SetOfSoftTexture("--silhouette-reuse", params, &SoftTextureParams::silhouette_reuse,
                               false, [&](uint32_t& value) { return SetReuse(text, value); });
     }},
    {"--count-bits", "N", "Bits that a count is sent in: auto, 8 or 16 (default auto)",
     [](TechniqueParams& params, std::string_view text) {
       return SetOfSoftTexture("--count-bits", params, &SoftTextureParams::count_bits, false,
                               [&](CountBits& value) {
                                 return SetNamed("--count-bits", kCountBitsNames, text, value);
                               });
     }},
};

}  // namespace

std::span<const ShadingOption> ShadingOptions() { return kOptions; }

}  // namespace penumbra
