// Lights given on the command line: --rect-light "corner edge_u edge_v radiance" and its like.
//
//   for (const LightOption& option : LightOptions()) app.add_option(option.name, …, option.help);
//   auto light = ParseLight(option, "0 2 0  1 0 0  0 0 1  5");
#pragma once

#include <span>
#include <string_view>

#include "absl/status/statusor.h"
#include "render/scene/area_light.h"

namespace penumbra {

struct LightOption {
  const char* name;  // "--rect-light"
  const char* id;    // of the light it makes; the second one is called ID-2
  const char* form;  // what its numbers are, in order
  const char* help;
  // How many numbers come before the light's strength, which is one number or three, and after.
  size_t numbers_before;
  size_t numbers_after;
  bool after_is_optional;
  // Takes before + 3 + after numbers: a single strength has been spread to three by then.
  LightShape (*make)(std::span<const float> numbers);
};

std::span<const LightOption> LightOptions();

// Only the count and the finiteness of the numbers are checked; the scene checks what they mean.
//
// Errors  kInvalidArgument, reasons NUMBER and NUMBER_COUNT; the field path is the option's name.
absl::StatusOr<LightShape> ParseLight(const LightOption& option, std::string_view text);

// Angles are given in degrees: what the scene would say of them in radians is said in degrees here.
//
// Errors  kInvalidArgument RANGE, with a field of the form: "--spot-light.inner_deg"
absl::Status CheckAngles(const LightOption& option, const LightShape& shape);

}  // namespace penumbra
