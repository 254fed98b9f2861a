#include "render/technique/soft_texture/receiver_transform.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace penumbra {
namespace {

// The sine of the angle to the receiver's plane below which a direction lies in it: what single
// precision leaves of a unit vector's component.
constexpr double kGrazingSine = 0x1.0p-19;

}  // namespace

std::optional<ReceiverTransform> ReceiverTransform::Create(const Parallelogram& patch,
                                                           const LightSample& sample,
                                                           double min_height) {
  const DVec3 b(patch.origin), e_x(patch.edge_u), e_y(patch.edge_v), point(sample.point);
  const DVec3 front = glm::normalize(glm::cross(e_x, e_y));
  const DVec3 e_w = sample.at_infinity ? -point : b - point;
  const double height = -glm::dot(front, e_w);
  if (std::abs(height) <= (sample.at_infinity ? kGrazingSine : min_height)) return std::nullopt;

  const DVec3 n_x = glm::cross(e_w, e_y);
  const DVec3 n_y = glm::cross(e_x, e_w);
  ReceiverTransform map;
  map.origin_ = b;
  map.row_x_ = n_x / glm::dot(n_x, e_x);
  map.row_y_ = n_y / glm::dot(n_y, e_y);
  // α_w n_w is the plane's normal over the signed height, which avoids the scale of the edges.
  map.row_w_ = sample.at_infinity ? DVec3(0.0) : -front / height;
  map.sample_height_ =
      sample.at_infinity ? std::copysign(std::numeric_limits<double>::infinity(), height) : height;
  return map;
}

// Coordinates carry 24 bits. What lies in the receiver's plane is off it by a few units in the last
// place of the largest coordinate; 32 of them are still a twentieth of a millimetre for a building
// of 30 m. A surface that is not quite flat leaves the plane by more, to either side.
double SurfaceOffset(const ReceiverPatch& receiver) {
  const Parallelogram& patch = receiver.patch;
  double largest = 0;
  for (const Vec2 uv : {Vec2(0, 0), Vec2(1, 0), Vec2(0, 1), Vec2(1, 1)}) {
    const DVec3 corner = glm::abs(DVec3(patch.At(uv)));
    largest = std::max({largest, corner.x, corner.y, corner.z});
  }
  const double size = glm::length(DVec3(patch.edge_u)) + glm::length(DVec3(patch.edge_v));
  return std::max(std::ldexp(std::max(largest, size), -19), 2 * receiver.deviation_m);
}

}  // namespace penumbra
