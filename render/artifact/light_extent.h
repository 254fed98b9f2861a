// How far a light reaches, and how far away it is.
//
//   const LightExtent extent(light);
//   if (extent.Height(origin, normal).low > 0) …  // all of it is above the plane
#pragma once

#include <array>
#include <optional>

#include "render/math/vec.h"
#include "render/scene/area_light.h"
#include "render/scene/light_sample.h"

namespace penumbra {

class LightExtent {
 public:
  struct Interval {
    double low, high;
  };
  // Of a rectangle or a disk.
  struct Plane {
    DVec3 point, normal;  // the front's, of length 1
    bool two_sided;       // the light shines from both faces
  };

  explicit LightExtent(const AreaLight& light);

  bool is_at_infinity() const { return is_at_infinity_; }
  const std::optional<Plane>& plane() const { return plane_; }
  DVec3 center() const { return center_; }

  // The light's half width along the unit vector `direction`.
  double HalfWidth(DVec3 direction) const;
  // The least distance from `point` to the surface of a rectangle or disk, to the centre of others.
  double Distance(DVec3 point) const;
  // Over the plane through `point` with the unit normal `normal`.
  Interval Height(DVec3 point, DVec3 normal) const;

 private:
  DVec3 center_{0.0};
  DVec3 half_u_{0.0}, half_v_{0.0};  // half edges of a rectangle
  double radius_ = 0;                // of a disk or sphere
  std::optional<Plane> plane_;
  bool is_at_infinity_ = false;
};

// The light's middle, homogeneous: a place (w = 1), or the direction towards it, of length 1 and
// w = 0.
DVec4 PlaceOfMiddle(const AreaLight& light);
// The same as the light's only sample.
LightSample MiddleOf(const AreaLight& light);

}  // namespace penumbra
