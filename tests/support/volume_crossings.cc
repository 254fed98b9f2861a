#include "tests/support/volume_crossings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace penumbra::testing {
namespace {

// One side of a triangle, as homogeneous pixels: at least 0 within.
struct Side {
  double x, y, w;

  Side(DVec3 a, DVec3 b, double sign)
      : x(sign * (a.y * b.z - a.z * b.y)),
        y(sign * (a.z * b.x - a.x * b.z)),
        w(sign * (a.x * b.y - a.y * b.x)) {}

  double At(double px, double py) const { return x * px + y * py + w; }
  // A point on the side itself is within one of the two triangles that have it.
  bool Holds(double value) const {
    return value > 0 || (value == 0 && (x > 0 || (x == 0 && y > 0)));
  }
};

struct Range {
  double first, last;
};

// Where in a row the side may hold, with a pixel to spare.
void Narrow(const Side& side, double py, Range& range) {
  const double offset = side.y * py + side.w;
  if (side.x > 0) range.first = std::max(range.first, -offset / side.x - 1);
  if (side.x < 0) range.last = std::min(range.last, -offset / side.x + 1);
}

// Rows, or columns, of pixels around corners that are all before the eye.
Range Around(const std::array<double, 3>& at, const std::array<double, 3>& w, double size) {
  if (std::min({w[0], w[1], w[2]}) <= 0) return {0, size - 1};
  Range range{size, -1};
  for (int k = 0; k < 3; ++k) {
    range.first = std::min(range.first, std::floor(at[k] / w[k] - 1));
    range.last = std::max(range.last, std::ceil(at[k] / w[k] + 1));
  }
  return {std::clamp(range.first, 0.0, size), std::clamp(range.last, -1.0, size - 1)};
}

}  // namespace

VolumeCrossings::VolumeCrossings(const EyeImage& eye, std::vector<double> inverse_depths)
    : eye_(eye),
      surface_(std::move(inverse_depths)),
      odd_(surface_.size()),
      count_(surface_.size()) {}

VolumeCrossings::Corner VolumeCrossings::CornerOf(const Vec4& world) const {
  const DVec4 clip = eye_.clip_from_world * DVec4(world);
  return {.at = DVec3(0.5 * (clip.x + clip.w) * eye_.width, 0.5 * (clip.y + clip.w) * eye_.height,
                      clip.w),
          .inverse = world.w};
}

void VolumeCrossings::Add(std::span<const Vec4> vertices, std::span<const uint32_t> indices,
                          std::span<const int8_t> weights) {
  std::vector<Corner> corners;
  for (const Vec4& vertex : vertices) corners.push_back(CornerOf(vertex));
  for (size_t i = 0; i + 2 < indices.size(); i += 3) {
    Draw(corners[indices[i]], corners[indices[i + 1]], corners[indices[i + 2]],
         weights.empty() ? 1 : weights[i / 3], false);
  }
}

void VolumeCrossings::AddCaps(std::span<const Vec4> clip_corners, int weight) {
  const auto corner = [&](size_t i) {
    const DVec4 clip(clip_corners[i]);
    return Corner{.at = DVec3(0.5 * (clip.x + clip.w) * eye_.width,
                              0.5 * (clip.y + clip.w) * eye_.height, clip.w),
                  .inverse = 0};
  };
  for (size_t i = 0; i + 2 < clip_corners.size(); i += 3) {
    Draw(corner(i), corner(i + 1), corner(i + 2), weight, true);
  }
}

void VolumeCrossings::Invert() {
  for (uint8_t& odd : odd_) odd ^= 1;
  for (int& count : count_) ++count;
}

void VolumeCrossings::Draw(const Corner& a, const Corner& b, const Corner& c, int weight,
                           bool is_cap) {
  const double volume = glm::dot(a.at, glm::cross(b.at, c.at));
  if (volume == 0 || !std::isfinite(volume)) return;
  const double sign = volume > 0 ? 1 : -1;
  const std::array<Side, 3> sides = {Side(b.at, c.at, sign), Side(c.at, a.at, sign),
                                     Side(a.at, b.at, sign)};
  const std::array<double, 3> w = {a.at.z, b.at.z, c.at.z};
  const Range rows = Around({a.at.y, b.at.y, c.at.y}, w, eye_.height);
  const Range columns = Around({a.at.x, b.at.x, c.at.x}, w, eye_.width);
  for (double y = rows.first; y <= rows.last; ++y) {
    Range range{columns.first, columns.last};
    for (const Side& side : sides) Narrow(side, y + 0.5, range);
    for (double x = std::max(std::floor(range.first), columns.first); x <= range.last; ++x) {
      std::array<double, 3> value;
      bool is_in = true;
      for (int k = 0; k < 3; ++k) {
        value[k] = sides[k].At(x + 0.5, y + 0.5);
        is_in = is_in && sides[k].Holds(value[k]);
      }
      if (!is_in) continue;
      const size_t pixel = static_cast<size_t>(y) * eye_.width + static_cast<size_t>(x);
      const double inverse =
          (value[0] * a.inverse + value[1] * b.inverse + value[2] * c.inverse) / std::abs(volume);
      if (!is_cap && !(inverse > surface_[pixel] && inverse * eye_.near <= 1)) continue;
      odd_[pixel] ^= 1;
      count_[pixel] += is_cap || volume > 0 ? weight : -weight;
    }
  }
}

}  // namespace penumbra::testing
