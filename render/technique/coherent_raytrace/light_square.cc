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
    kind_ = Kind::kSphere;
    frame_.origin_ = sphere->center;
    frame_.radius_ = sphere->radius;
  } else if (const auto* point = std::get_if<PointLight>(&light.shape)) {
    frame_.origin_ = point->position;
  } else if (const auto* spot = std::get_if<SpotLight>(&light.shape)) {
    frame_.origin_ = spot->position;
  } else {
    const auto& distant = std::get<DistantLight>(light.shape);
    const Basis basis = BasisAround(DVec3(distant.to_light));
    const double radius = std::sin(0.5 * double{distant.angular_diameter});
    kind_ = radius > 0 ? Kind::kSky : Kind::kDirection;
    frame_.radius_ = static_cast<float>(radius);
    frame_.u_ = Vec3(basis.s), frame_.v_ = Vec3(basis.t), frame_.n_ = Vec3(basis.n);
  }
  frame_.kind_ = kind_;
}

void LightSquare::TakeRectangle(const RectangleLight& light) {
  kind_ = Kind::kRectangle;
  two_sided_ = light.two_sided;
  const DVec3 u(light.edge_u), v(light.edge_v);
  const DVec3 n = glm::normalize(glm::cross(u, v));
  const DVec3 across_v = glm::cross(v, n), across_u = glm::cross(n, u);
  frame_.origin_ = light.corner;
  frame_.u_ = light.edge_u, frame_.v_ = light.edge_v, frame_.n_ = Vec3(n);
  frame_.dual_u_ = Vec3(across_v / glm::dot(u, across_v));
  frame_.dual_v_ = Vec3(across_u / glm::dot(v, across_u));
}

void LightSquare::TakeDisk(const DiskLight& light) {
  kind_ = Kind::kDisk;
  two_sided_ = light.two_sided;
  const Basis basis = BasisAround(-DVec3(light.normal));  // as SampleLight
  const double radius = light.radius;
  frame_.origin_ = light.center;
  frame_.u_ = Vec3(radius * basis.s), frame_.v_ = Vec3(radius * basis.t);
  frame_.n_ = Vec3(-basis.n);
  frame_.dual_u_ = Vec3(basis.s / radius), frame_.dual_v_ = Vec3(basis.t / radius);
}

float LightSquare::width() const {
  switch (kind_) {
    case Kind::kRectangle:
    case Kind::kDisk: {
      const float width = std::min(glm::length(frame_.u_), glm::length(frame_.v_));
      return kind_ == Kind::kDisk ? 2 * width : width;
    }
    case Kind::kSphere:
      return 2 * frame_.radius_;
    case Kind::kSky:
    case Kind::kPoint:
    case Kind::kDirection:
      break;
  }
  return 0.0f;
}

bool LightSquare::IsDarkAt(Vec3 point) const {
  return !two_sided_ && !(glm::dot(frame_.n_, point - frame_.origin_) > 0);
}

LightSquare::Seen LightSquare::From(Vec3 point) const {
  Seen seen = frame_;
  seen.point_ = point;
  if (kind_ == Kind::kRectangle || kind_ == Kind::kDisk) {
    const Vec3 off = point - seen.origin_;
    seen.height_ = -glm::dot(off, seen.n_);
    seen.along_u_ = glm::dot(off, seen.dual_u_);
    seen.along_v_ = glm::dot(off, seen.dual_v_);
  } else if (kind_ == Kind::kSphere) {
    const DVec3 to_point = DVec3(point) - DVec3(seen.origin_);
    const bool centered = glm::dot(to_point, to_point) == 0;
    const Basis basis = BasisAround(centered ? DVec3(0, 1, 0) : -to_point);
    seen.u_ = Vec3(basis.s), seen.v_ = Vec3(basis.t), seen.n_ = Vec3(basis.n);
  }
  return seen;
}

Vec2 LightSquare::Seen::OnDisk(Vec2 square) const {
  return kind_ == Kind::kRectangle ? square : Vec2(ConcentricDisk(DVec2(square)));
}

Vec3 LightSquare::Seen::TargetAt(Vec2 square) const {
  switch (kind_) {
    case Kind::kRectangle:
      return origin_ + square.x * u_ + square.y * v_;
    case Kind::kDisk: {
      const Vec2 d = OnDisk(square);
      return origin_ + d.x * u_ + d.y * v_;
    }
    case Kind::kSphere: {
      const Vec2 d = OnDisk(square);
      const float bulge = std::sqrt(std::max(0.0f, 1 - glm::dot(d, d)));
      return origin_ + radius_ * (d.x * u_ + d.y * v_ - bulge * n_);
    }
    case Kind::kSky: {
      const Vec2 d = radius_ * OnDisk(square);
      return d.x * u_ + d.y * v_ + std::sqrt(std::max(0.0f, 1 - glm::dot(d, d))) * n_;
    }
    case Kind::kPoint:
      return origin_;
    case Kind::kDirection:
      return n_;
  }
  return origin_;
}

Vec2 LightSquare::Seen::DiskOf(Vec3 blocker) const {
  const Vec3 way = blocker - point_;
  if (kind_ == Kind::kSky) {
    const float along = glm::dot(way, n_);
    if (!(along > 0)) return Vec2(kOutside);
    return Vec2(glm::dot(way, u_), glm::dot(way, v_)) / (radius_ * glm::length(way));
  }
  const Vec3 d = glm::normalize(way), to_center = origin_ - point_;
  const float along = glm::dot(to_center, d);
  const float inside2 = along * along - glm::dot(to_center, to_center) + radius_ * radius_;
  if (!(inside2 >= 0)) return Vec2(kOutside);
  const float distance = along - std::sqrt(inside2);
  if (!(distance > glm::length(way))) return Vec2(kOutside);
  const Vec3 on_sphere = distance * d - to_center;
  return Vec2(glm::dot(on_sphere, u_), glm::dot(on_sphere, v_)) / radius_;
}

Vec2 LightSquare::Seen::SquareOf(Vec3 blocker) const {
  if (kind_ == Kind::kPoint || kind_ == Kind::kDirection) return Vec2(0.5f);
  Vec2 at;
  if (kind_ == Kind::kRectangle || kind_ == Kind::kDisk) {
    const Vec3 way = blocker - point_;
    const float stretch = height_ / glm::dot(way, n_);
    if (!(stretch > 1)) return Vec2(kOutside);
    at = Vec2(along_u_, along_v_) + stretch * Vec2(glm::dot(way, dual_u_), glm::dot(way, dual_v_));
    if (kind_ == Kind::kRectangle) return at;
  } else {
    at = DiskOf(blocker);
  }
  return glm::dot(at, at) < 1 ? Vec2(ConcentricSquare(DVec2(at))) : Vec2(kOutside);
}

void LightSquare::Seen::PartsBehind(const CellGrid& grid, const Vec4* blockers, size_t count,
                                    uint32_t* part) const {
  if (kind_ == Kind::kRectangle) {
    penumbra::PartsBehind(grid,
                          {.point = point_,
                           .normal = n_,
                           .dual_u = dual_u_,
                           .dual_v = dual_v_,
                           .height = height_,
                           .along_u = along_u_,
                           .along_v = along_v_},
                          blockers, count, part);
    return;
  }
  const uint32_t along = grid.along();
  const auto place = [along](float s) {
    return std::min(static_cast<uint32_t>(s * static_cast<float>(along)), along - 1);
  };
  for (size_t i = 0; i < count; ++i) {
    const Vec2 at = SquareOf(Vec3(blockers[i]));
    const bool is_on_light = at.x >= 0 && at.x < 1 && at.y >= 0 && at.y < 1;
    part[i] = is_on_light ? place(at.y) * along + place(at.x) : grid.off();
  }
}

float LightSquare::Seen::WeightAt(Vec2 square, Vec3 normal) const {
  if (kind_ == Kind::kPoint || kind_ == Kind::kDirection) return 1.0f;
  const Vec3 target = TargetAt(square);
  if (kind_ == Kind::kSky) {
    return std::max(0.0f, glm::dot(normal, target)) / std::max(1e-6f, glm::dot(target, n_));
  }
  const Vec3 way = target - point_;
  const float distance2 = glm::dot(way, way), cos_surface = std::max(0.0f, glm::dot(normal, way));
  if (!(distance2 > 0)) return 0.0f;
  if (kind_ != Kind::kSphere) return cos_surface / (distance2 * distance2);
  // An area of the disc is one of the sphere times its cosine to the disc's axis.
  const Vec3 out = (target - origin_) / radius_;
  const float cos_light = std::max(0.0f, -glm::dot(out, way));
  return cos_surface * cos_light / (distance2 * distance2 * std::max(1e-3f, -glm::dot(out, n_)));
}

LightSquare::Seen::Side LightSquare::Seen::SideOf(Vec3 normal) const {
  float middle = glm::dot(normal, origin_ - point_), reach = 0.0f;
  const Vec2 lean(glm::dot(normal, u_), glm::dot(normal, v_));
  if (kind_ == Kind::kRectangle) {
    middle += 0.5f * (lean.x + lean.y);
    reach = 0.5f * (std::abs(lean.x) + std::abs(lean.y));
  } else if (kind_ == Kind::kDisk) {
    reach = glm::length(lean);
  } else if (kind_ == Kind::kSphere) {
    reach = radius_;
  } else if (kind_ == Kind::kSky || kind_ == Kind::kDirection) {
    middle = std::sqrt(1 - radius_ * radius_) * glm::dot(normal, n_);
    reach = radius_ * glm::length(lean);
  }
  reach *= 1 + kRim;
  if (middle - reach > 0) return Side::kAbove;
  return middle + reach <= 0 ? Side::kBelow : Side::kBoth;
}

}  // namespace penumbra
