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
  bool MayMeet(const Aabb& box) const { return MayMeet(box, slabs_.size()); }
  // The same by the hull's own faces alone: ten times as fast, and true more often.
  bool MayMeetByFaces(const Aabb& box) const { return MayMeet(box, face_count_); }

  // The region for boxes in the space of a mesh that lie within `mesh_bounds`. It takes in what
  // rounding does to vertices that are placed in single precision.
  ShadowRegion InMesh(const Affine& world_from_mesh, const Aabb& mesh_bounds) const;

 private:
  struct Slab {
    DVec3 axis;  // unit length in world space
    double lo;
    double hi;  // +∞ where a distant light lies
  };

  ShadowRegion() = default;
  // Returns whether the slab is one of the hull's faces.
  bool AddSlab(DVec3 axis, std::span<const DVec3> points, std::span<const DVec3> directions);
  bool MayMeet(const Aabb& box, size_t slab_count) const;

  std::vector<Slab> slabs_;
  size_t face_count_ = 0;  // of the slabs, the first
  double extent_ = 0.0;    // largest coordinate of the hull's finite points, in m
  // A gap narrower than this part of the coordinates is no gap; 0: slabs are as wide as they must.
  double relative_slack_ = 0.0;
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
