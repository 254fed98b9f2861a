#include "render/scene/silhouette_bounds.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "render/scene/silhouette_kernel.h"

namespace penumbra {

FaceBound Around(const FaceBound& a, const FaceBound& b) {
  if (a.radius < 0) return b;
  if (b.radius < 0) return a;
  FaceBound both;
  const DVec3 apart = b.center - a.center;
  const double distance = glm::length(apart);
  if (distance + b.radius <= a.radius) {
    both.center = a.center;
    both.radius = a.radius;
  } else if (distance + a.radius <= b.radius) {
    both.center = b.center;
    both.radius = b.radius;
  } else {
    both.radius = 0.5 * (distance + a.radius + b.radius);
    both.center = a.center + (both.radius - a.radius) / distance * apart;
  }
  const DVec3 sum = a.axis + b.axis;
  both.axis = glm::dot(sum, sum) > 1e-12 ? glm::normalize(sum) : a.axis;
  for (const FaceBound& part : {a, b}) {
    const double turn = std::acos(std::clamp(glm::dot(both.axis, part.axis), -1.0, 1.0));
    both.spread = std::max(both.spread, part.spread + turn);
  }
  return both;
}

void Push(const FaceBound& bound, ClusterLevel& level) {
  const double slack = kFacingSlack;
  const bool is_narrow = bound.spread < 1.5;
  const auto push = [](std::vector<float>& values, double value) {
    values.push_back(static_cast<float>(value));
  };
  push(level.x, bound.center.x);
  push(level.y, bound.center.y);
  push(level.z, bound.center.z);
  push(level.radius, bound.radius * (1 + slack));
  push(level.axis_x, bound.axis.x);
  push(level.axis_y, bound.axis.y);
  push(level.axis_z, bound.axis.z);
  push(level.cos_spread, is_narrow ? std::cos(bound.spread) - slack : -1.0);
  push(level.sin_spread, is_narrow ? std::sin(bound.spread) + slack : 0.0);
}

}  // namespace penumbra
