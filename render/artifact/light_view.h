// How one point of a light sees the scene.
//
//   const DVec3 p = view.Project(point);   // pixel x, y and depth
#pragma once

#include <cstdint>

#include "render/math/basis.h"
#include "render/math/vec.h"

namespace penumbra {

// Where a light looks from and to. Depth is measured along `axes.n`, in metres.
struct LightFrame {
  DVec3 origin{0.0};  // world space: the light's centre; of a distant light, the scene's
  Basis axes{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

  DVec3 FromWorld(DVec3 p) const { return DirectionFromWorld(p - origin); }
  DVec3 DirectionFromWorld(DVec3 d) const {
    return DVec3(glm::dot(d, axes.s), glm::dot(d, axes.t), glm::dot(d, axes.n));
  }
  DVec3 ToWorld(DVec3 q) const { return origin + q.x * axes.s + q.y * axes.t + q.z * axes.n; }
};

// A part of an image plane: slopes x/z and y/z as seen from a point, metres as seen from infinitely
// far.
struct Window {
  DVec2 min{0.0};
  DVec2 max{0.0};

  bool empty() const { return !(min.x < max.x && min.y < max.y); }
  DVec2 size() const { return max - min; }
};

Window Intersection(const Window& a, const Window& b);

// A projection onto a plane parallel to that of `frame`. Pixel (i, j) is centred at (i + ½, j + ½).
// Depth is the distance to the eye along frame.axes.n, in metres; from infinitely far, the distance
// to the frame's origin along it, which may be negative.
struct LightView {
  LightFrame frame;
  bool from_infinity = false;
  DVec3 eye{0.0};  // in the frame: the point; from infinitely far, what x and y move by per metre
                   // of depth, towards the light (z is not used)
  Window window;   // of the image
  uint32_t width = 0;
  uint32_t height = 0;
  double near = 0.0;  // depths between which all lies that is to be seen; nearer things are cut,
  double far = 0.0;   // but from infinitely far

  // Whether it has no pixels to see anything with.
  bool empty() const { return width == 0 || height == 0 || window.empty(); }

  DVec2 pixels_per_slope() const { return DVec2(width, height) / window.size(); }

  // (x, y, depth) of a point in world space; x and y mean nothing where depth ≤ 0, but from
  // infinitely far.
  DVec3 Project(DVec3 world) const { return ProjectInFrame(frame.FromWorld(world)); }
  DVec3 ProjectInFrame(DVec3 q) const;
  // The point in world space that Project takes to `pixel` and `depth`.
  DVec3 PointAt(DVec2 pixel, double depth) const;
};

// To the last bit.
bool IsSameView(const LightView& a, const LightView& b);

}  // namespace penumbra
