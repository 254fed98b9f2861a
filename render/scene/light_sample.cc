#include "render/scene/light_sample.h"

#include <algorithm>
#include <cmath>

#include "render/math/basis.h"
#include "render/math/concentric_disk.h"
#include "render/scene/jittered_grid.h"

namespace penumbra {
namespace {

struct Place {
  DVec2 square;
  DVec3 target;

  LightSample operator()(const RectangleLight& light) const {
    const DVec3 p =
        DVec3(light.corner) + square.x * DVec3(light.edge_u) + square.y * DVec3(light.edge_v);
    return {.point = Vec3(p)};
  }
  LightSample operator()(const DiskLight& light) const {
    const Basis basis = BasisAround(-DVec3(light.normal));  // lamps mostly shine down
    const DVec2 d = double{light.radius} * ConcentricDisk(square);
    return {.point = Vec3(DVec3(light.center) + d.x * basis.s + d.y * basis.t)};
  }
  // On the hemisphere towards the target, evenly over the disc that the target sees of it.
  LightSample operator()(const SphereLight& light) const {
    const DVec3 to_target = target - DVec3(light.center);
    const bool centered = glm::dot(to_target, to_target) == 0;
    const Basis basis = BasisAround(centered ? DVec3(0, 1, 0) : -to_target);
    const DVec2 d = ConcentricDisk(square);
    const double bulge = std::sqrt(std::max(0.0, 1 - glm::dot(d, d)));
    const DVec3 out = d.x * basis.s + d.y * basis.t - bulge * basis.n;
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
