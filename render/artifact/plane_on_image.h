// A surface's plane as a light's view sees it: how near it is at the pixels around a point.
//
//   const auto plane = PlaneOnImage::Find(view, point, normal);
//   if (plane) … plane->At(DVec2(x + 0.5, y + 0.5)) …
#pragma once

#include <optional>

#include "render/artifact/light_view.h"
#include "render/math/vec.h"

namespace penumbra {

// Beyond this slope, in pixels' widths a pixel, a surface is seen too much from its edge for its
// depth at the next pixel to be told.
inline constexpr double kMaxSteepness = 16.0;

// Grows towards the light: 1/depth, from infinitely far −depth. Either is linear on the image of a
// plane.
inline double NearnessOf(bool from_infinity, double depth) {
  return from_infinity ? -depth : 1 / depth;
}
inline double DepthAt(bool from_infinity, double nearness) {
  return from_infinity ? -nearness : 1 / nearness;
}

// With q = (x, y, z), the point in the view's frame as its eye sees it, n, the normal there, and p,
// a pixel's size on the image, nearness r changes from pixel to pixel by
//
//   g = p · n.xy / (n · q)       from infinitely far  g = p · n.xy / (n · d),
//
// where rays run along d; cut to ±kMaxSteepness · w, where w = p · r, from infinitely far p, is
// what a pixel's width is in terms of r.
struct PlaneOnImage {
  DVec2 at;  // the point, in pixels
  double nearness;
  DVec2 gradient;  // of nearness, a pixel
  double width;    // of a pixel, in terms of nearness

  // nullopt: the point is not in the view's window.
  //
  // point, normal  in world space; the normal of any length, towards either side
  static std::optional<PlaneOnImage> Find(const LightView& view, DVec3 point, DVec3 normal);

  double At(DVec2 pixel) const { return nearness + glm::dot(gradient, pixel - at); }
  // How much the nearness of what is seen at one pixel, and stored for its centre, may be off.
  double spread() const { return width + std::abs(gradient.x) + std::abs(gradient.y); }
};

}  // namespace penumbra
