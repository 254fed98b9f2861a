#include "render/artifact/light_extent.h"

#include <algorithm>
#include <cmath>
#include <variant>

namespace penumbra {
namespace {

double DistanceToSegment(DVec3 point, DVec3 from, DVec3 to) {
  const DVec3 along = to - from;
  const double t = glm::dot(point - from, along) / glm::dot(along, along);
  return glm::length(point - from - std::clamp(t, 0.0, 1.0) * along);
}

// To center ± u ± v.
double DistanceToParallelogram(DVec3 point, DVec3 center, DVec3 u, DVec3 v) {
  const DVec3 normal = glm::cross(u, v);
  const DVec3 p = point - center;
  const double area2 = glm::dot(normal, normal);
  const double s = glm::dot(glm::cross(p, v), normal) / area2;
  const double t = glm::dot(glm::cross(u, p), normal) / area2;
  if (std::abs(s) <= 1 && std::abs(t) <= 1) {
    return std::abs(glm::dot(p, normal)) / std::sqrt(area2);
  }
  return std::min({DistanceToSegment(p, u + v, u - v), DistanceToSegment(p, u - v, -u - v),
                   DistanceToSegment(p, -u - v, v - u), DistanceToSegment(p, v - u, u + v)});
}

}  // namespace

LightExtent::LightExtent(const AreaLight& light) {
  if (const auto* rectangle = std::get_if<RectangleLight>(&light.shape)) {
    half_u_ = 0.5 * DVec3(rectangle->edge_u);
    half_v_ = 0.5 * DVec3(rectangle->edge_v);
    center_ = DVec3(rectangle->corner) + half_u_ + half_v_;
    plane_ = {center_, glm::normalize(glm::cross(half_u_, half_v_)), rectangle->two_sided};
  } else if (const auto* disk = std::get_if<DiskLight>(&light.shape)) {
    center_ = DVec3(disk->center);
    radius_ = disk->radius;
    plane_ = {center_, glm::normalize(DVec3(disk->normal)), disk->two_sided};
  } else if (const auto* sphere = std::get_if<SphereLight>(&light.shape)) {
    center_ = DVec3(sphere->center);
    radius_ = sphere->radius;
  } else if (const auto* point = std::get_if<PointLight>(&light.shape)) {
    center_ = DVec3(point->position);
  } else if (const auto* spot = std::get_if<SpotLight>(&light.shape)) {
    center_ = DVec3(spot->position);
  } else {
    is_at_infinity_ = true;
  }
}

double LightExtent::HalfWidth(DVec3 direction) const {
  if (!plane_) return radius_;
  if (radius_ > 0) {
    const double along = glm::dot(direction, plane_->normal);
    return radius_ * std::sqrt(std::max(0.0, 1 - along * along));
  }
  return std::abs(glm::dot(direction, half_u_)) + std::abs(glm::dot(direction, half_v_));
}

double LightExtent::Distance(DVec3 point) const {
  if (plane_ && radius_ == 0) return DistanceToParallelogram(point, center_, half_u_, half_v_);
  if (!plane_) return glm::length(point - center_);
  const DVec3 p = point - center_;
  const double along = glm::dot(p, plane_->normal);
  const double across = glm::length(p - along * plane_->normal);
  return std::hypot(along, std::max(0.0, across - radius_));
}

LightExtent::Interval LightExtent::Height(DVec3 point, DVec3 normal) const {
  const double middle = glm::dot(normal, center_ - point), half = HalfWidth(normal);
  return {middle - half, middle + half};
}

DVec4 PlaceOfMiddle(const AreaLight& light) {
  if (const auto* sun = std::get_if<DistantLight>(&light.shape)) {
    return DVec4(glm::normalize(DVec3(sun->to_light)), 0);
  }
  return DVec4(LightExtent(light).center(), 1);
}

LightSample MiddleOf(const AreaLight& light) {
  const DVec4 middle = PlaceOfMiddle(light);
  return {.point = Vec3(DVec3(middle)), .at_infinity = middle.w == 0};
}

}  // namespace penumbra
