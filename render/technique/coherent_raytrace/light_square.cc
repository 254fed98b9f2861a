#include "render/technique/coherent_raytrace/light_square.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "render/math/basis.h"
#include "render/math/concentric_disk.h"

namespace penumbra {
namespace {

using Kind = LightSquare::Kind;

// Of the light's reach: a plane that passes this close to its edge counts as cutting it.
constexpr float kRim = 1e-5f;

}  // namespace

LightSquare::LightSquare(const AreaLight& light) {
  if (const auto* rectangle = std::get_if<RectangleLight>(&light.shape)) {
    TakeRectangle(*rectangle);
  } else if (const auto* disk = std::get_if<DiskLight>(&light.shape)) {
    TakeDisk(*disk);
  } else if (const auto* sphere = std::get_if<SphereLight>(&light.shape)) {
    frame_.kind = Kind::kSphere;
    frame_.origin = sphere->center;
    frame_.radius = sphere->radius;
  } else if (const auto* point = std::get_if<PointLight>(&light.shape)) {
    frame_.origin = point->position;
  } else if (const auto* spot = std::get_if<SpotLight>(&light.shape)) {
    frame_.origin = spot->position;
  } else {
    const auto& distant = std::get<DistantLight>(light.shape);
    const Basis basis = BasisAround(DVec3(distant.to_light));
    const double radius = std::sin(0.5 * double{distant.angular_diameter});
    frame_.kind = radius > 0 ? Kind::kSky : Kind::kDirection;
    frame_.radius = static_cast<float>(radius);
    frame_.u = Vec3(basis.s), frame_.v = Vec3(basis.t), frame_.n = Vec3(basis.n);
  }
}

void LightSquare::TakeRectangle(const RectangleLight& light) {
  frame_.kind = Kind::kRectangle;
  two_sided_ = light.two_sided;
  const DVec3 u(light.edge_u), v(light.edge_v);
  const DVec3 n = glm::normalize(glm::cross(u, v));
  const DVec3 across_v = glm::cross(v, n), across_u = glm::cross(n, u);
  frame_.origin = light.corner;
  frame_.u = light.edge_u, frame_.v = light.edge_v, frame_.n = Vec3(n);
  frame_.dual_u = Vec3(across_v / glm::dot(u, across_v));
  frame_.dual_v = Vec3(across_u / glm::dot(v, across_u));
}

void LightSquare::TakeDisk(const DiskLight& light) {
  frame_.kind = Kind::kDisk;
  two_sided_ = light.two_sided;
  const Basis basis = BasisAround(-DVec3(light.normal));  // as SampleLight
  const double radius = light.radius;
  frame_.origin = light.center;
  frame_.u = Vec3(radius * basis.s), frame_.v = Vec3(radius * basis.t);
  frame_.n = Vec3(-basis.n);
  frame_.dual_u = Vec3(basis.s / radius), frame_.dual_v = Vec3(basis.t / radius);
}

float LightSquare::width() const {
  switch (kind()) {
    case Kind::kRectangle:
    case Kind::kDisk: {
      const float width = std::min(glm::length(frame_.u), glm::length(frame_.v));
      return kind() == Kind::kDisk ? 2 * width : width;
    }
    case Kind::kSphere:
      return 2 * frame_.radius;
    case Kind::kSky:
    case Kind::kPoint:
    case Kind::kDirection:
      break;
  }
  return 0.0f;
}

bool LightSquare::IsDarkAt(Vec3 point) const {
  return !two_sided_ && !(glm::dot(frame_.n, point - frame_.origin) > 0);
}

Vec2 LightSquare::PlaceOf(Vec2 square) const {
  return kind() == Kind::kRectangle ? square : Vec2(ConcentricDisk(DVec2(square)));
}

LightSquare::Seen LightSquare::From(Vec3 point) const {
  Seen seen;
  SquareView& view = seen.view_ = frame_;
  view.point = point;
  if (kind() == Kind::kRectangle || kind() == Kind::kDisk) {
    const Vec3 off = point - view.origin;
    view.height = -glm::dot(off, view.n);
    view.along_u = glm::dot(off, view.dual_u);
    view.along_v = glm::dot(off, view.dual_v);
  } else if (kind() == Kind::kSphere) {
    const DVec3 to_point = DVec3(point) - DVec3(view.origin);
    const bool centered = glm::dot(to_point, to_point) == 0;
    const Basis basis = BasisAround(centered ? DVec3(0, 1, 0) : -to_point);
    view.u = Vec3(basis.s), view.v = Vec3(basis.t), view.n = Vec3(basis.n);
  }
  return seen;
}

Vec3 LightSquare::Seen::TargetAt(Vec2 square) const {
  switch (view_.kind) {
    case Kind::kRectangle:
      return view_.origin + square.x * view_.u + square.y * view_.v;
    case Kind::kDisk: {
      const Vec2 d = Vec2(ConcentricDisk(DVec2(square)));
      return view_.origin + d.x * view_.u + d.y * view_.v;
    }
    case Kind::kSphere: {
      const Vec2 d = Vec2(ConcentricDisk(DVec2(square)));
      const float bulge = std::sqrt(std::max(0.0f, 1 - glm::dot(d, d)));
      return view_.origin + view_.radius * (d.x * view_.u + d.y * view_.v - bulge * view_.n);
    }
    case Kind::kSky: {
      const Vec2 d = view_.radius * Vec2(ConcentricDisk(DVec2(square)));
      return d.x * view_.u + d.y * view_.v +
             std::sqrt(std::max(0.0f, 1 - glm::dot(d, d))) * view_.n;
    }
    case Kind::kPoint:
      return view_.origin;
    case Kind::kDirection:
      return view_.n;
  }
  return view_.origin;
}

LightSquare::Seen::Side LightSquare::Seen::SideOf(Vec3 normal) const {
  float middle = glm::dot(normal, view_.origin - view_.point), reach = 0.0f;
  const Vec2 lean(glm::dot(normal, view_.u), glm::dot(normal, view_.v));
  if (view_.kind == Kind::kRectangle) {
    middle += 0.5f * (lean.x + lean.y);
    reach = 0.5f * (std::abs(lean.x) + std::abs(lean.y));
  } else if (view_.kind == Kind::kDisk) {
    reach = glm::length(lean);
  } else if (view_.kind == Kind::kSphere) {
    reach = view_.radius;
  } else if (view_.kind == Kind::kSky || view_.kind == Kind::kDirection) {
    middle = std::sqrt(1 - view_.radius * view_.radius) * glm::dot(normal, view_.n);
    reach = view_.radius * glm::length(lean);
  }
  reach *= 1 + kRim;
  if (middle - reach > 0) return Side::kAbove;
  return middle + reach <= 0 ? Side::kBelow : Side::kBoth;
}

}  // namespace penumbra
