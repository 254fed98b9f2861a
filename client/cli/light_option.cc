#include "client/cli/light_option.h"

#include <numbers>
#include <string>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/cli/numbers.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

using Numbers = std::span<const float>;

constexpr float kRadiansPerDegree = 0.017453292519943295f;

absl::Status WrongAngle(const LightOption& option, const char* field, float radians,
                        const std::string& need) {
  return FieldError(absl::StatusCode::kInvalidArgument, "RANGE",
                    absl::StrCat(option.name, ".", field),
                    absl::StrCat("found ", radians / kRadiansPerDegree, ", need ", need));
}

LightShape MakeRectangle(Numbers n) {
  return RectangleLight{.corner = Vec3At(n, 0),
                        .edge_u = Vec3At(n, 3),
                        .edge_v = Vec3At(n, 6),
                        .radiance = Vec3At(n, 9)};
}

LightShape MakeDisk(Numbers n) {
  return DiskLight{
      .center = Vec3At(n, 0), .normal = Vec3At(n, 3), .radius = n[6], .radiance = Vec3At(n, 7)};
}

LightShape MakeSphere(Numbers n) {
  return SphereLight{.center = Vec3At(n, 0), .radius = n[3], .radiance = Vec3At(n, 4)};
}

LightShape MakePoint(Numbers n) {
  return PointLight{.position = Vec3At(n, 0), .intensity = Vec3At(n, 3)};
}

LightShape MakeSpot(Numbers n) {
  return SpotLight{.position = Vec3At(n, 0),
                   .direction = Vec3At(n, 3),
                   .intensity = Vec3At(n, 6),
                   .inner_angle = n[9] * kRadiansPerDegree,
                   .outer_angle = n[10] * kRadiansPerDegree};
}

LightShape MakeSun(Numbers n) {
  DistantLight sun{.to_light = Vec3At(n, 0), .irradiance = Vec3At(n, 3)};
  if (n.size() > 6) sun.angular_diameter = n[6] * kRadiansPerDegree;
  return sun;
}

constexpr LightOption kLightOptions[] = {
    {"--rect-light", "rect-light", "corner edge_u edge_v radiance",
     "A parallelogram that shines from both faces", 9, 0, false, MakeRectangle},
    {"--disk-light", "disk-light", "center normal radius radiance",
     "A disc that shines from both faces", 7, 0, false, MakeDisk},
    {"--sphere-light", "sphere-light", "center radius radiance", "A glowing ball", 4, 0, false,
     MakeSphere},
    {"--point-light", "point-light", "position intensity", "A point; its shadows are hard", 3, 0,
     false, MakePoint},
    {"--spot-light", "spot-light", "position direction intensity inner_deg outer_deg",
     "A point with a cone: full inside the inner half angle, none outside the outer one", 6, 2,
     false, MakeSpot},
    {"--sun", "sun", "direction_to_sun irradiance [angular_diameter_deg]",
     "Light from infinitely far; without a diameter its shadows are hard", 3, 1, true, MakeSun},
};

}  // namespace

std::span<const LightOption> LightOptions() { return kLightOptions; }

absl::StatusOr<LightShape> ParseLight(const LightOption& option, std::string_view text) {
  auto parsed = ParseNumbers(option.name, text);
  if (!parsed.ok()) return parsed.status();
  std::vector<float> numbers = *std::move(parsed);

  const size_t grey = option.numbers_before + 1 + option.numbers_after;
  const size_t least = option.after_is_optional ? grey - option.numbers_after : grey;
  const auto is_count = [&](size_t n) {
    return numbers.size() >= n && numbers.size() <= n + grey - least;
  };
  if (is_count(least)) {
    const auto strength = numbers.begin() + static_cast<ptrdiff_t>(option.numbers_before);
    numbers.insert(strength, 2, float{*strength});
  } else if (!is_count(least + 2)) {
    return FieldError(absl::StatusCode::kInvalidArgument, "NUMBER_COUNT", option.name,
                      absl::StrCat("found ", numbers.size(), " numbers, need ", least, " or ",
                                   least + 2, ": ", option.form));
  }
  return option.make(numbers);
}

absl::Status CheckAngles(const LightOption& option, const LightShape& shape) {
  // Those of scene_check.cc.
  constexpr float kLeast = 1e-4f;
  constexpr float kMost = std::numbers::pi_v<float> / 2 + 1e-6f;
  if (const auto* spot = std::get_if<SpotLight>(&shape)) {
    const float outer = spot->outer_angle;
    if (!(outer >= kLeast && outer <= kMost)) {
      return WrongAngle(option, "outer_deg", outer, "0.006 to 90");
    }
    if (!(spot->inner_angle >= 0 && spot->inner_angle < outer)) {
      return WrongAngle(option, "inner_deg", spot->inner_angle,
                        absl::StrCat("0 to less than ", outer / kRadiansPerDegree));
    }
  }
  const auto* sun = std::get_if<DistantLight>(&shape);
  if (sun && !(sun->angular_diameter >= 0 && sun->angular_diameter <= kMost)) {
    return WrongAngle(option, "angular_diameter_deg", sun->angular_diameter, "0 to 90");
  }
  return absl::OkStatus();
}

}  // namespace penumbra
