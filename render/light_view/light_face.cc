#include "render/light_view/light_face.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <variant>

namespace penumbra {
namespace {

// Slopes beyond which a window is as good as unbounded.
constexpr double kUnbounded = 1e9;

constexpr double kNoDistance = 1e-200;

constexpr Window kAnywhere{.min = DVec2(-kUnbounded), .max = DVec2(kUnbounded)};
constexpr Window kAround{.min = DVec2(-1.0), .max = DVec2(1.0)};
// Of the four faces beside one that looks ahead: `y` is towards ahead.
constexpr Window kBeside{.min = DVec2(-1.0, 0.0), .max = DVec2(1.0, 1.0)};

Window Square(double side) { return {.min = DVec2(-side), .max = DVec2(side)}; }

bool IsInside(const Window& inner, const Window& outer) {
  return glm::all(glm::greaterThanEqual(inner.min, outer.min)) &&
         glm::all(glm::lessThanEqual(inner.max, outer.max));
}

void Add(std::vector<LightFace>& faces, const LightFrame& frame, const Aabb& bounds,
         const Window& limit) {
  const Window window = WindowOf(frame, DVec3(0.0), 0.0, bounds, limit);
  if (!window.empty()) faces.push_back({.frame = frame, .window = window});
}

// All that lies before a plane light, whose normal is `ahead.axes.n`.
void AddHemisphere(std::vector<LightFace>& faces, const LightFrame& ahead, const Aabb& bounds) {
  const Window seen = WindowOf(ahead, DVec3(0.0), 0.0, bounds, kAnywhere);
  if (seen.empty()) return;
  if (IsInside(seen, Square(kMaxSlope))) return Add(faces, ahead, bounds, kAnywhere);
  Add(faces, ahead, bounds, kAround);
  const Basis& axes = ahead.axes;
  for (const DVec3& n : {axes.s, axes.t, -axes.s, -axes.t}) {
    const Basis beside{.s = glm::cross(axes.n, n), .t = axes.n, .n = n};
    Add(faces, {ahead.origin, beside}, bounds, kBeside);
  }
}

// Both ways, or the front alone.
std::vector<LightFace> PlaneFaces(const LightFrame& front, bool two_sided, const Aabb& bounds) {
  std::vector<LightFace> faces;
  AddHemisphere(faces, front, bounds);
  if (!two_sided) return faces;
  const Basis& axes = front.axes;
  AddHemisphere(faces, {front.origin, {.s = axes.s, .t = -axes.t, .n = -axes.n}}, bounds);
  return faces;
}

std::vector<LightFace> SphereFaces(DVec3 center, const Aabb& bounds) {
  std::vector<LightFace> faces;
  for (const DVec3& axis : {DVec3(0, -1, 0), DVec3(1, 0, 0), DVec3(0, 0, 1), DVec3(-1, 0, 0),
                            DVec3(0, 0, -1), DVec3(0, 1, 0)}) {
    Add(faces, {center, BasisAround(axis)}, bounds, kAround);
  }
  return faces;
}

struct Faces {
  const Aabb& bounds;

  std::vector<LightFace> operator()(const RectangleLight& light) const {
    const DVec3 u(light.edge_u), v(light.edge_v);
    const DVec3 n = glm::normalize(glm::cross(u, v)), s = glm::normalize(u);
    const LightFrame front{DVec3(light.corner) + 0.5 * (u + v),
                           {.s = s, .t = glm::cross(n, s), .n = n}};
    return PlaneFaces(front, light.two_sided, bounds);
  }
  std::vector<LightFace> operator()(const DiskLight& light) const {
    const LightFrame front{DVec3(light.center), BasisAround(DVec3(light.normal))};
    return PlaneFaces(front, light.two_sided, bounds);
  }
  std::vector<LightFace> operator()(const SphereLight& light) const {
    return SphereFaces(DVec3(light.center), bounds);
  }
  std::vector<LightFace> operator()(const PointLight& light) const {
    return SphereFaces(DVec3(light.position), bounds);
  }
  std::vector<LightFace> operator()(const SpotLight& light) const {
    const LightFrame ahead{DVec3(light.position), BasisAround(DVec3(light.direction))};
    const double slope = std::tan(double{light.outer_angle});
    std::vector<LightFace> faces;
    // A right angle has no tangent, or, rounded, one of either sign.
    if (slope > 0 && slope <= kMaxSlope) {
      Add(faces, ahead, bounds, Square(slope));
    } else {
      AddHemisphere(faces, ahead, bounds);
    }
    return faces;
  }
  std::vector<LightFace> operator()(const DistantLight& light) const {
    const LightFrame frame{DVec3(bounds.center()), BasisAround(-DVec3(light.to_light))};
    const Window window = ShearedWindow(frame, DVec2(0.0), bounds);
    if (window.empty()) return {};
    return {{.frame = frame, .from_infinity = true, .window = window}};
  }
};

}  // namespace

DVec3 CornerOf(const Aabb& box, int corner) {
  return DVec3((corner & 1) ? box.max.x : box.min.x, (corner & 2) ? box.max.y : box.min.y,
               (corner & 4) ? box.max.z : box.min.z);
}

std::vector<LightFace> FacesOf(const AreaLight& light, const Aabb& bounds) {
  if (bounds.empty()) return {};
  return std::visit(Faces{bounds}, light.shape);
}

Window WindowOf(const LightFrame& frame, DVec3 eye, double near, const Aabb& box,
                const Window& limit) {
  Window window{.min = DVec2(kUnbounded), .max = DVec2(-kUnbounded)};
  std::array<DVec3, 8> corners;
  for (int i = 0; i < 8; ++i) corners[i] = frame.FromWorld(CornerOf(box, i)) - eye;
  const auto add = [&window](DVec2 slope) {
    window.min = glm::min(window.min, glm::max(slope, DVec2(-kUnbounded)));
    window.max = glm::max(window.max, glm::min(slope, DVec2(kUnbounded)));
  };
  for (int i = 0; i < 8; ++i) {
    if (corners[i].z > near) add(DVec2(corners[i]) / corners[i].z);
    for (int bit = 1; bit < 8; bit <<= 1) {
      const DVec3 &a = corners[i], &b = corners[i | bit];
      if ((i & bit) || (a.z > near) == (b.z > near)) continue;
      // Where the box's edge meets the plane; at no distance a slope has no bound.
      const DVec2 p = glm::mix(DVec2(a), DVec2(b), (near - a.z) / (b.z - a.z));
      add(p / std::max(near, kNoDistance));
    }
  }
  return Intersection(window, limit);
}

Window ShearedWindow(const LightFrame& frame, DVec2 slope, const Aabb& box) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Window window{.min = DVec2(kInfinity), .max = DVec2(-kInfinity)};
  for (int i = 0; i < 8; ++i) {
    const DVec3 q = frame.FromWorld(CornerOf(box, i));
    const DVec2 p = DVec2(q) + q.z * slope;
    window.min = glm::min(window.min, p);
    window.max = glm::max(window.max, p);
  }
  return window;
}

}  // namespace penumbra
