// A shadow ray as a depth image shows it: the epipolar ray.
//
//   const ImageOrigin origin(image, point);
//   const ImageRay ray(origin, way);
//   if (const auto seen = ray.Clip(ray.ParametersOf({0, 1}))) …
#pragma once

#include <optional>

#include "render/technique/coherent_raytrace/depth_pyramid.h"

namespace penumbra {

// Parameters along a ray.
struct WayInterval {
  double from, to;

  bool empty() const { return !(from < to); }
};

// Where rays begin, as an image shows it.
struct ImageOrigin {
  ImageOrigin(const DepthPyramid& seen_in, DVec3 point);

  const DepthPyramid* image;
  DVec2 pixels;  // per slope
  DVec3 q;       // in the view's frame; relative to the eye, where there is one
  DVec3 start;   // x and y in pixels, nearness
};

// The points origin + t · way. On the image x, y and nearness are linear in s, which grows with t:
//
//   s = t / (z(t) z(0))  from a point,   s = t  from infinitely far.
//
// Source  Lischinski and Rappoport 1998; McMillan 1997 for the epipolar geometry
class ImageRay {
 public:
  ImageRay(const ImageOrigin& origin, DVec3 way);

  // From t to s. What is not before the near plane is left out; empty where that is all.
  WayInterval ParametersOf(WayInterval t) const;
  double ParameterAt(double t) const;  // s
  double WayAt(double s) const;        // t

  // What of [from, to], in s, lies within the image.
  WayInterval Clip(WayInterval s) const;
  // Of an interval in s, in pixels.
  double Length(WayInterval s) const { return (s.to - s.from) * glm::length(DVec2(step_)); }

  const DVec3& start() const { return origin_->start; }
  const DVec3& step() const { return step_; }  // of x, y and nearness, per s

 private:
  const ImageOrigin* origin_;
  DVec3 step_;
  double depth_;      // z(0), 1 from infinitely far
  double deepening_;  // dz/dt, 0 from infinitely far
};

}  // namespace penumbra
