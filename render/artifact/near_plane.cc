#include "render/artifact/near_plane.h"

#include <algorithm>
#include <cmath>

namespace penumbra {
namespace {

DVec4 Row(const DMat4& m, int row) { return DVec4(m[0][row], m[1][row], m[2][row], m[3][row]); }

struct Corner {
  DVec4 world;
  double before;
  double reaches;
};

// The part of a convex polygon where `value` is not negative.
template <typename Value>
std::vector<Corner> Clipped(const std::vector<Corner>& polygon, const Value& value) {
  std::vector<Corner> clipped;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Corner& a = polygon[i];
    const Corner& b = polygon[(i + 1) % polygon.size()];
    const double at_a = value(a), at_b = value(b);
    if (at_a >= 0) clipped.push_back(a);
    if ((at_a < 0) == (at_b < 0)) continue;
    // From the same end whichever way the edge runs: neighbours cut it at the same place.
    const bool from_a = at_a < 0;
    const Corner &out = from_a ? a : b, &in = from_a ? b : a;
    const double at_out = from_a ? at_a : at_b, at_in = from_a ? at_b : at_a;
    const double t = at_out / (at_out - at_in);
    clipped.push_back({.world = out.world + t * (in.world - out.world),
                       .before = out.before + t * (in.before - out.before),
                       .reaches = out.reaches + t * (in.reaches - out.reaches)});
  }
  return clipped;
}

// To numbers that single precision holds.
Vec4 Scaled(const DVec4& v) {
  const double most = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z), std::abs(v.w)});
  return most > 0 ? Vec4(v / most) : Vec4(0.0f);
}

}  // namespace

NearPlane::NearPlane(const DMat4& clip_from_world, double near, const DVec4& light, double least)
    : clip_from_world_(clip_from_world), light_(light) {
  const DVec4 row_x = Row(clip_from_world, 0), row_y = Row(clip_from_world, 1);
  const DVec4 row_w = Row(clip_from_world, 3);
  const DVec4 plane = row_w - DVec4(0, 0, 0, near);
  const double at_light = glm::dot(plane, light);
  toward_light_ = at_light < 0 ? -plane : plane;
  distance_ = std::abs(at_light);
  if (distance_ < least) {  // so that `light` is as far from it as that
    const double more = least - distance_;
    if (light.w != 0) {
      toward_light_.w += more;
    } else {
      toward_light_ += DVec4(more * DVec3(light), 0.0);
    }
    distance_ = least;
  }
  const glm::dmat3 rows = glm::transpose(glm::dmat3(DVec3(row_x), DVec3(row_y), DVec3(row_w)));
  const glm::dmat3 place = glm::inverse(rows);
  const DVec3 offset(row_x.w, row_y.w, row_w.w);
  constexpr double kSides[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  for (size_t i = 0; i < 4; ++i) {
    rectangle_[i] = place * (near * DVec3(kSides[i][0], kSides[i][1], 1) - offset);
  }
}

void NearPlane::AddCap(const std::array<DVec4, 3>& world, std::vector<Vec4>& corners) const {
  std::vector<Corner> polygon;
  for (const DVec4& v : world) {
    const double before = Before(v);
    polygon.push_back({.world = v, .before = before, .reaches = Reaches(v, before)});
  }
  polygon = Clipped(polygon, [](const Corner& c) { return c.before; });
  if (light_.w != 0) polygon = Clipped(polygon, [](const Corner& c) { return c.reaches; });
  std::vector<DVec4> places;
  for (const Corner& c : polygon) places.push_back(c.world);
  AddWholeCap(places, corners);
}

void NearPlane::AddWholeCap(std::span<const DVec4> world, std::vector<Vec4>& corners) const {
  std::vector<Vec4> clip;
  for (const DVec4& v : world) {
    clip.push_back(Scaled(clip_from_world_ * Shadow(v, Before(v))));
  }
  for (size_t i = 2; i < clip.size(); ++i) {
    corners.insert(corners.end(), {clip[0], clip[i - 1], clip[i]});
  }
}

}  // namespace penumbra
