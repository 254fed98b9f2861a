// An eye's near plane as a light sees it, and what of the light's surface is before it.
//
//   const NearPlane plane(clip_from_world, near, light, least);
//   plane.AddCap(corners_world, caps.corners);
#pragma once

#include <array>
#include <span>
#include <vector>

#include "render/math/vec.h"

namespace penumbra {

class NearPlane {
 public:
  // light  homogeneous: a position (w = 1), or the direction towards it (w = 0)
  // least  how far the light is from the plane at least; nearer, or in it, it is taken to be as
  // far,
  //        since shadows in a plane that light runs along are those beside it
  NearPlane(const DMat4& clip_from_world, double near, const DVec4& light, double least);

  // What the plane's distance is, towards the light's side, at a homogeneous place: > 0 before the
  // plane.
  double Before(const DVec4& world) const { return glm::dot(toward_light_, world); }
  const DVec4& toward_light() const { return toward_light_; }
  // w of Shadow(): what is not > 0 has no shadow on the plane, since light runs away from it.
  double Reaches(const DVec4& world, double before) const {
    return distance_ * world.w - before * light_.w;
  }

  // Where light that passes through a place that is `before` the plane meets it, homogeneous.
  DVec4 Shadow(const DVec4& world, double before) const {
    return distance_ * world - before * light_;
  }

  // Appends the shadow of what of the triangle is before the plane, in clip space, three corners a
  // triangle.
  void AddCap(const std::array<DVec4, 3>& world, std::vector<Vec4>& corners) const;
  // The same of a convex polygon all of which is before the plane, and has a shadow on it.
  void AddWholeCap(std::span<const DVec4> world, std::vector<Vec4>& corners) const;

  // The corners of the part of the plane that the eye sees, in world space.
  const std::array<DVec3, 4>& rectangle() const { return rectangle_; }

 private:
  DMat4 clip_from_world_;
  DVec4 light_;
  DVec4 toward_light_;
  double distance_;  // of the light
  std::array<DVec3, 4> rectangle_;
};

}  // namespace penumbra
