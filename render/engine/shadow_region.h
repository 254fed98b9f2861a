// Where something must be to cast a shadow from a light onto a patch: their convex hull.
//
//   ShadowRegion region(*light, receiver.patch);
//   if (!region.MayMeet(WorldBounds(instance))) …  // whatever it does, the shadow stays as it is
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "render/math/aabb.h"
#include "render/math/vec.h"
#include "render/scene/area_light.h"
#include "render/scene/receiver.h"

namespace penumbra {

// The hull, kept as slabs: for each of some directions, the interval that the hull covers along it.
// The directions are those among which the separating-axis theorem finds the one that parts a box
// from a polyhedron: the box's and the hull's face normals, and the cross products of their edges.
class ShadowRegion {
 public:
  // Round lights are taken as the square or the cube around them; a distant light makes the region
  // unbounded towards it.
  ShadowRegion(const AreaLight& light, const Parallelogram& patch);

  // False only if `box` does not touch the region; an empty box never does. True is not certain.
  bool MayMeet(const Aabb& box) const;

 private:
  struct Slab {
    DVec3 axis;  // unit length
    double lo;
    double hi;  // +∞ where a distant light lies
  };

  void AddSlab(DVec3 axis, std::span<const DVec3> points, std::span<const DVec3> directions);

  std::vector<Slab> slabs_;
  double extent_ = 0.0;  // largest coordinate of the hull's finite points, in m
};

// The region last asked for, kept: light and receiver mostly stay while other things move.
class KnownShadowRegion {
 public:
  const ShadowRegion& Between(std::shared_ptr<const AreaLight> light, const Parallelogram& patch);

 private:
  struct Known {
    std::shared_ptr<const AreaLight> light;
    Parallelogram patch;
    ShadowRegion region;
  };
  std::optional<Known> known_;
};

}  // namespace penumbra
