#include "render/scene/shadow_region.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>
#include <variant>

#include "render/math/basis.h"

namespace penumbra {
namespace {

// Bounds and the technique's own arithmetic are single precision: placing and projecting a vertex
// takes about ten operations, each wrong by 2⁻²⁴ of the coordinates at most. A gap narrower than
// seventeen times as much is no gap.
constexpr double kRelativeSlack = 1e-5;
// Points of a face are in one plane to within this part of the coordinates.
constexpr double kFlatness = 1e-9;
// The sine below which a direction counts as parallel to a plane that was built to contain it.
constexpr double kParallelSine = 1e-9;

constexpr std::array<DVec3, 3> kAxes = {DVec3(1, 0, 0), DVec3(0, 1, 0), DVec3(0, 0, 1)};

// The hull of a light: finite points, directions to what is infinitely far, and the directions of
// its own edges.
struct LightHull {
  std::vector<DVec3> points{};
  std::vector<DVec3> directions{};
  std::vector<DVec3> edges{};
};

LightHull HullOf(const RectangleLight& light) {
  const DVec3 c(light.corner), u(light.edge_u), v(light.edge_v);
  return {.points = {c, c + u, c + v, c + u + v}, .directions = {}, .edges = {u, v}};
}

LightHull HullOf(const DiskLight& light) {
  const auto [u, v, n] = BasisAround(DVec3(light.normal));
  const DVec3 c(light.center), ru = double{light.radius} * u, rv = double{light.radius} * v;
  return {.points = {c - ru - rv, c + ru - rv, c - ru + rv, c + ru + rv},
          .directions = {},
          .edges = {u, v}};
}

LightHull HullOf(const SphereLight& light) {
  LightHull hull;
  for (int corner = 0; corner < 8; ++corner) {
    const DVec3 sign((corner & 1) ? 1 : -1, (corner & 2) ? 1 : -1, (corner & 4) ? 1 : -1);
    hull.points.push_back(DVec3(light.center) + double{light.radius} * sign);
  }
  return hull;  // its edges are the axes, which are tried anyway
}

LightHull HullOf(const PointLight& light) { return {.points = {DVec3(light.position)}}; }
LightHull HullOf(const SpotLight& light) { return {.points = {DVec3(light.position)}}; }

LightHull HullOf(const DistantLight& light) {
  const auto [u, v, axis] = BasisAround(DVec3(light.to_light));
  if (light.angular_diameter <= 0.0f) return {.points = {}, .directions = {axis}};
  const double t = std::tan(0.5 * light.angular_diameter);
  LightHull hull;
  for (const DVec2 s : {DVec2(-1, -1), DVec2(1, -1), DVec2(1, 1), DVec2(-1, 1)}) {
    hull.directions.push_back(glm::normalize(axis + t * (s.x * u + s.y * v)));
  }
  return hull;
}

double LargestCoordinate(DVec3 p) {
  return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
}

// Directions that may part a box from the hull of patch and light.
std::vector<DVec3> CandidateAxes(const LightHull& light, std::span<const DVec3> corners,
                                 DVec3 edge_u, DVec3 edge_v) {
  std::vector<DVec3> plain(kAxes.begin(), kAxes.end());
  plain.push_back(edge_u);
  plain.push_back(edge_v);
  plain.insert(plain.end(), light.edges.begin(), light.edges.end());

  std::vector<DVec3> joining = light.directions;
  for (const DVec3 corner : corners) {
    for (const DVec3 point : light.points) joining.push_back(point - corner);
  }

  std::vector<DVec3> axes(kAxes.begin(), kAxes.end());
  for (size_t i = 0; i < plain.size(); ++i) {
    for (size_t j = i + 1; j < plain.size(); ++j) axes.push_back(glm::cross(plain[i], plain[j]));
    for (const DVec3 edge : joining) axes.push_back(glm::cross(plain[i], edge));
  }
  for (size_t i = 0; i < light.directions.size(); ++i) {
    for (size_t j = i + 1; j < light.directions.size(); ++j) {
      axes.push_back(glm::cross(light.directions[i], light.directions[j]));
    }
  }
  return axes;
}

}  // namespace

ShadowRegion::ShadowRegion(const AreaLight& light, const Parallelogram& patch)
    : relative_slack_(kRelativeSlack) {
  const LightHull hull = std::visit([](const auto& shape) { return HullOf(shape); }, light.shape);
  const DVec3 origin(patch.origin), edge_u(patch.edge_u), edge_v(patch.edge_v);
  const std::array<DVec3, 4> corners = {origin, origin + edge_u, origin + edge_v,
                                        origin + edge_u + edge_v};
  std::vector<DVec3> points(corners.begin(), corners.end());
  points.insert(points.end(), hull.points.begin(), hull.points.end());
  for (const DVec3 point : points) extent_ = std::max(extent_, LargestCoordinate(point));
  for (const DVec3 axis : CandidateAxes(hull, corners, edge_u, edge_v)) {
    if (AddSlab(axis, points, hull.directions)) std::swap(slabs_[face_count_++], slabs_.back());
  }
}

bool ShadowRegion::AddSlab(DVec3 axis, std::span<const DVec3> points,
                           std::span<const DVec3> directions) {
  const double length = glm::length(axis);
  if (!(length > 0.0) || !std::isfinite(length)) return false;
  axis /= length;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Slab slab{.axis = axis, .lo = kInfinity, .hi = -kInfinity};
  for (const DVec3 point : points) {
    slab.lo = std::min(slab.lo, glm::dot(axis, point));
    slab.hi = std::max(slab.hi, glm::dot(axis, point));
  }
  const double flat = kFlatness * extent_;
  int on_lo = 0, on_hi = 0;
  for (const DVec3 point : points) {
    on_lo += glm::dot(axis, point) <= slab.lo + flat;
    on_hi += glm::dot(axis, point) >= slab.hi - flat;
  }
  for (const DVec3 direction : directions) {
    const double sine = glm::dot(axis, direction);
    if (sine > kParallelSine) slab.hi = kInfinity;
    if (sine < -kParallelSine) slab.lo = -kInfinity;
    on_lo += std::abs(sine) <= kParallelSine;
    on_hi += std::abs(sine) <= kParallelSine;
  }
  if (slab.lo == -kInfinity && slab.hi == kInfinity) return false;
  slabs_.push_back(slab);
  const bool is_along_an_axis = LargestCoordinate(axis) == 1.0;
  return is_along_an_axis || (slab.lo > -kInfinity && on_lo >= 3) ||
         (slab.hi < kInfinity && on_hi >= 3);
}

ShadowRegion ShadowRegion::InMesh(const Affine& world_from_mesh, const Aabb& mesh_bounds) const {
  ShadowRegion region;
  region.face_count_ = face_count_;
  const DVec3 place(world_from_mesh[3]);
  const DVec3 corner = glm::max(glm::abs(DVec3(mesh_bounds.min)), glm::abs(DVec3(mesh_bounds.max)));
  DVec3 reach = glm::abs(place);
  for (int c = 0; c < 3; ++c) reach += corner[c] * glm::abs(DVec3(world_from_mesh[c]));
  const double slack = kRelativeSlack * (extent_ + LargestCoordinate(reach));
  region.slabs_.reserve(slabs_.size());
  for (const Slab& slab : slabs_) {
    const double offset = glm::dot(slab.axis, place);
    Slab& in_mesh = region.slabs_.emplace_back();
    for (int c = 0; c < 3; ++c) in_mesh.axis[c] = glm::dot(slab.axis, DVec3(world_from_mesh[c]));
    in_mesh.lo = slab.lo - offset - slack;
    in_mesh.hi = slab.hi - offset + slack;
  }
  return region;
}

bool ShadowRegion::MayMeet(const Aabb& box, size_t slab_count) const {
  if (box.empty()) return false;
  const DVec3 center = 0.5 * (DVec3(box.min) + DVec3(box.max));
  const DVec3 half = 0.5 * (DVec3(box.max) - DVec3(box.min));
  const double slack =
      relative_slack_ * (extent_ + LargestCoordinate(center) + LargestCoordinate(half));
  for (size_t i = 0; i < slab_count; ++i) {
    const Slab& slab = slabs_[i];
    const double middle = glm::dot(slab.axis, center);
    const double radius = glm::dot(glm::abs(slab.axis), half) + slack;
    if (middle - radius > slab.hi || middle + radius < slab.lo) return false;
  }
  return true;
}

const ShadowRegion& KnownShadowRegion::Between(std::shared_ptr<const AreaLight> light,
                                               const Parallelogram& patch) {
  if (!known_ || known_->light != light || known_->patch != patch) {
    const ShadowRegion region(*light, patch);
    known_.emplace(Known{std::move(light), patch, region});
  }
  return known_->region;
}

}  // namespace penumbra
