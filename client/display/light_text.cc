#include "client/display/light_text.h"

#include <array>
#include <charconv>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"

namespace penumbra {
namespace {

// In the order of LightShape.
constexpr std::array<std::string_view, 6> kKinds = {"rectangle", "disk", "sphere",
                                                    "point",     "spot", "distant"};
static_assert(std::variant_size_v<LightShape> == kKinds.size());

// Calls visit(member) with each number, vector and flag of a light, in a fixed order.
template <typename Visit>
void ForEachMember(RectangleLight& light, Visit visit) {
  visit(light.corner), visit(light.edge_u), visit(light.edge_v), visit(light.radiance);
  visit(light.two_sided);
}
template <typename Visit>
void ForEachMember(DiskLight& light, Visit visit) {
  visit(light.center), visit(light.normal), visit(light.radius), visit(light.radiance);
  visit(light.two_sided);
}
template <typename Visit>
void ForEachMember(SphereLight& light, Visit visit) {
  visit(light.center), visit(light.radius), visit(light.radiance);
}
template <typename Visit>
void ForEachMember(PointLight& light, Visit visit) {
  visit(light.position), visit(light.intensity);
}
template <typename Visit>
void ForEachMember(SpotLight& light, Visit visit) {
  visit(light.position), visit(light.direction), visit(light.intensity);
  visit(light.inner_angle), visit(light.outer_angle);
}
template <typename Visit>
void ForEachMember(DistantLight& light, Visit visit) {
  visit(light.to_light), visit(light.angular_diameter), visit(light.irradiance);
}

struct Writer {
  std::string& text;

  void operator()(float x) const { absl::StrAppendFormat(&text, " %.9g", x); }
  void operator()(bool x) const { (*this)(x ? 1.0f : 0.0f); }
  void operator()(Vec3 v) const {
    for (int c = 0; c < 3; ++c) (*this)(v[c]);
  }
};

struct Reader {
  std::vector<float>& numbers;  // last first
  bool& is_complete;

  void operator()(float& x) const {
    if (numbers.empty()) {
      is_complete = false;
      return;
    }
    x = numbers.back();
    numbers.pop_back();
  }
  void operator()(bool& x) const {
    float number = 0;
    (*this)(number);
    x = number != 0;
  }
  void operator()(Vec3& v) const {
    for (int c = 0; c < 3; ++c) (*this)(v[c]);
  }
};

// Sets `shape` to the alternative called `kind`, at its defaults.
template <size_t... I>
bool SetKind(std::string_view kind, LightShape& shape, std::index_sequence<I...>) {
  return ((kKinds[I] == kind ? (shape.emplace<I>(), true) : false) || ...);
}

absl::Status NoLight() {
  return absl::InvalidArgumentError("light: found no light, need an id, a kind and its numbers");
}

}  // namespace

std::string LightText(const AreaLight& light) {
  std::string text = absl::StrCat(light.id, " ", std::string(kKinds[light.shape.index()]));
  LightShape shape = light.shape;
  std::visit([&](auto& one) { ForEachMember(one, Writer{text}); }, shape);
  return text;
}

absl::StatusOr<AreaLight> LightFromText(std::string_view text) {
  const std::vector<std::string> words =
      absl::StrSplit(absl::string_view(text.data(), text.size()), ' ');
  if (words.size() < 2) return NoLight();
  AreaLight light{.id = words[0]};
  if (!SetKind(words[1], light.shape, std::make_index_sequence<kKinds.size()>())) return NoLight();
  std::vector<float> numbers;
  for (size_t i = words.size(); i > 2; --i) {
    const std::string& word = words[i - 1];
    float number = 0;
    const auto read = std::from_chars(word.data(), word.data() + word.size(), number);
    if (read.ec != std::errc() || read.ptr != word.data() + word.size()) return NoLight();
    numbers.push_back(number);
  }
  bool is_complete = true;
  std::visit([&](auto& one) { ForEachMember(one, Reader{numbers, is_complete}); }, light.shape);
  if (!is_complete || !numbers.empty()) return NoLight();
  return light;
}

}  // namespace penumbra
