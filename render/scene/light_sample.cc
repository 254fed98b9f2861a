#include "render/scene/light_sample.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "render/math/random.h"

namespace penumbra {
namespace {

constexpr double kPi = std::numbers::pi;

// One of n cells of equal area that tile the unit square.
struct Cell {
  DVec2 corner;
  DVec2 size;
  DVec2 center() const { return corner + 0.5 * size; }
};

// Rows of about √n cells; where n is no rectangle, some rows hold one cell more and are that much
// taller, so that all areas stay 1/n. `aspect` is the light's width over its height: cells come out
// roughly square.
std::vector<Cell> TileUnitSquare(uint32_t n, double aspect) {
  const double ideal_rows = std::sqrt(n / std::clamp(aspect, 1.0 / n, 1.0 * n));
  const auto rows = std::clamp<uint32_t>(static_cast<uint32_t>(std::lround(ideal_rows)), 1, n);
  std::vector<Cell> cells;
  cells.reserve(n);
  double bottom = 0;
  for (uint32_t row = 0; row < rows; ++row) {
    const uint32_t first = static_cast<uint32_t>(uint64_t{n} * row / rows);
    const uint32_t columns = static_cast<uint32_t>(uint64_t{n} * (row + 1) / rows) - first;
    const DVec2 size(1.0 / columns, static_cast<double>(columns) / n);
    for (uint32_t column = 0; column < columns; ++column) {
      cells.push_back({{column * size.x, bottom}, size});
    }
    bottom += size.y;
  }
  return cells;
}

// An order of the cells whose every prefix is spread out: each next cell is the one furthest from
// those already taken, the first the one nearest the middle. Ties go to the lower index.
// Source  Gonzalez 1985, farthest-first traversal
std::vector<uint32_t> FarthestFirst(const std::vector<Cell>& cells, double aspect) {
  const auto distance2 = [&](DVec2 a, DVec2 b) {
    const DVec2 d = (a - b) * DVec2(aspect, 1.0);
    return glm::dot(d, d);
  };
  std::vector<double> nearest2(cells.size(), std::numeric_limits<double>::infinity());
  std::vector<uint32_t> order;
  order.reserve(cells.size());
  const auto by_center = [&](const Cell& a, const Cell& b) {
    return distance2(a.center(), DVec2(0.5)) < distance2(b.center(), DVec2(0.5));
  };
  auto next = static_cast<uint32_t>(std::min_element(cells.begin(), cells.end(), by_center) -
                                    cells.begin());
  while (order.size() < cells.size()) {
    order.push_back(next);
    for (size_t i = 0; i < cells.size(); ++i) {
      nearest2[i] = std::min(nearest2[i], distance2(cells[i].center(), cells[next].center()));
    }
    nearest2[next] = -1;
    next = static_cast<uint32_t>(std::max_element(nearest2.begin(), nearest2.end()) -
                                 nearest2.begin());
  }
  return order;
}

// n points of the unit square in a nested order, one jittered in each cell.
std::vector<DVec2> JitteredGrid(uint32_t n, double aspect, uint64_t seed) {
  const std::vector<Cell> cells = TileUnitSquare(n, aspect);
  std::vector<DVec2> points;
  points.reserve(n);
  for (const uint32_t c : FarthestFirst(cells, aspect)) {
    const DVec2 jitter(UniformAt(seed, c, 0), UniformAt(seed, c, 1));
    points.push_back(cells[c].corner + jitter * cells[c].size);
  }
  return points;
}

// From the unit square to the unit disc, area for area.
// Source  Shirley and Chiu 1997, concentric map
DVec2 ConcentricDisk(DVec2 square) {
  const DVec2 p = 2.0 * square - 1.0;
  if (p.x == 0 && p.y == 0) return DVec2(0.0);
  const bool wide = std::abs(p.x) > std::abs(p.y);
  const double radius = wide ? p.x : p.y;
  const double angle = wide ? kPi / 4 * (p.y / p.x) : kPi / 2 - kPi / 4 * (p.x / p.y);
  return radius * DVec2(std::cos(angle), std::sin(angle));
}

struct Basis {
  DVec3 s, t, n;  // orthonormal
};

Basis BasisAround(DVec3 axis) {
  const DVec3 n = glm::normalize(axis);
  const DVec3 away = std::abs(n.x) < 0.5 ? DVec3(1, 0, 0) : DVec3(0, 1, 0);
  const DVec3 s = glm::normalize(glm::cross(n, away));
  return {s, glm::cross(n, s), n};
}

struct Place {
  DVec2 square;
  DVec3 target;

  LightSample operator()(const RectangleLight& light) const {
    const DVec3 p =
        DVec3(light.corner) + square.x * DVec3(light.edge_u) + square.y * DVec3(light.edge_v);
    return {.point = Vec3(p)};
  }
  LightSample operator()(const DiskLight& light) const {
    const Basis basis = BasisAround(DVec3(light.normal));
    const DVec2 d = double{light.radius} * ConcentricDisk(square);
    return {.point = Vec3(DVec3(light.center) + d.x * basis.s + d.y * basis.t)};
  }
  // On the hemisphere towards the target, evenly over the disc that the target sees of it.
  LightSample operator()(const SphereLight& light) const {
    const DVec3 to_target = target - DVec3(light.center);
    const bool centered = glm::dot(to_target, to_target) == 0;
    const Basis basis = BasisAround(centered ? DVec3(0, 1, 0) : to_target);
    const DVec2 d = ConcentricDisk(square);
    const double bulge = std::sqrt(std::max(0.0, 1 - glm::dot(d, d)));
    const DVec3 out = d.x * basis.s + d.y * basis.t + bulge * basis.n;
    return {.point = Vec3(DVec3(light.center) + double{light.radius} * out)};
  }
  LightSample operator()(const PointLight& light) const { return {.point = light.position}; }
  LightSample operator()(const SpotLight& light) const { return {.point = light.position}; }
  // Evenly over the disc of directions, as projected on a surface that faces the light.
  LightSample operator()(const DistantLight& light) const {
    const Basis basis = BasisAround(DVec3(light.to_light));
    const DVec2 d = std::sin(0.5 * double{light.angular_diameter}) * ConcentricDisk(square);
    const double along = std::sqrt(std::max(0.0, 1 - glm::dot(d, d)));
    return {.point = Vec3(d.x * basis.s + d.y * basis.t + along * basis.n), .at_infinity = true};
  }
};

double AspectOf(const AreaLight& light) {
  const auto* rectangle = std::get_if<RectangleLight>(&light.shape);
  if (!rectangle) return 1;
  return glm::length(DVec3(rectangle->edge_u)) / glm::length(DVec3(rectangle->edge_v));
}

}  // namespace

uint32_t EffectiveSampleCount(const AreaLight& light, uint32_t count) {
  if (std::holds_alternative<PointLight>(light.shape) ||
      std::holds_alternative<SpotLight>(light.shape)) {
    return 1;
  }
  const auto* distant = std::get_if<DistantLight>(&light.shape);
  return distant && distant->angular_diameter == 0 ? 1 : count;
}

std::vector<LightSample> SampleLight(const AreaLight& light, uint32_t count, uint64_t seed,
                                     Vec3 target) {
  const uint32_t n = EffectiveSampleCount(light, count);
  std::vector<LightSample> samples;
  samples.reserve(n);
  for (const DVec2& square : JitteredGrid(n, AspectOf(light), seed)) {
    LightSample sample = std::visit(Place{square, DVec3(target)}, light.shape);
    sample.weight = 1.0f / static_cast<float>(n);
    samples.push_back(sample);
  }
  return samples;
}

}  // namespace penumbra
