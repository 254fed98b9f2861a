// From the pixels of a light's middle view to those of another point's view, and back.
//
//   const ViewWarp warp(center, view);
//   const ImagePlane there = warp.ToView(here);   // the same surface, seen from the other point
#pragma once

#include <cmath>
#include <cstdint>

#include "render/artifact/light_view.h"
#include "render/math/vec.h"

namespace penumbra {

// A plane through a point of a surface, as an image shows it.
//
// Nearness is 1/z, from infinitely far −z: it grows towards the eye and is linear on the image.
struct ImagePlane {
  Vec2 at;         // in pixels, from where the image plane's (0, 0) is
  float nearness;  // at `at`
  Vec2 gradient;   // of nearness, a pixel

  float At(Vec2 place) const { return nearness + glm::dot(gradient, place - at); }
};

// Down to whole pixels, of what is not negative.
inline Vec2 PixelAt(Vec2 at) {
  return Vec2(static_cast<float>(static_cast<int32_t>(at.x)),
              static_cast<float>(static_cast<int32_t>(at.y)));
}

inline float NearnessOf(bool from_infinity, float depth) {
  return from_infinity ? -depth : 1.0f / depth;
}

// A plane n · q = d is n.x·u + n.y·v + n.z = d/z at the slopes (u, v): nearness is linear. An eye
// at e sees q as q − e. With r = 1/z and r' = 1/(z − e.z)
//
//   u' = (u − e.x·r) / (1 − e.z·r),   r' = r / (1 − e.z·r),
//
// which is equation (3) where e.z = 0, and the plane's d becomes d' = d − n · e, so that gradients
// grow by d/d'. With the plane's nearness at the slope 0, A = r − gradient · at,
//
//   d'/d = 1 − gradient · e.xy − A·e.z.
//
// From infinitely far, with r = −z, it is the same with e.z = 0.
//
// Source  Agrawala et al. 2000, §4, equation (3), and the projective case that it leaves to the
//         reader
struct ViewWarp {
  // Both views are of one frame and have the same pitch; the eye of `center` is the frame's origin.
  ViewWarp(const LightView& center, const LightView& view)
      : center_origin(-center.window.min * center.pixels_per_slope()),
        view_origin(-view.window.min * view.pixels_per_slope()),
        move(DVec2(view.eye) * center.pixels_per_slope()),
        ahead(view.from_infinity ? 0.0f : static_cast<float>(view.eye.z)) {}

  ImagePlane ToView(const ImagePlane& p) const { return Moved(p, move, ahead); }
  ImagePlane ToCenter(const ImagePlane& p) const { return Moved(p, -move, -ahead); }
  // Their `at` alone.
  Vec2 ToView(Vec2 at, float nearness) const {
    const Vec2 moved = at - nearness * move;
    return ahead == 0 ? moved : moved / (1 - ahead * nearness);
  }
  Vec2 ToCenter(Vec2 at, float nearness) const {
    const Vec2 moved = at + nearness * move;
    return ahead == 0 ? moved : moved / (1 + ahead * nearness);
  }

  Vec2 center_origin, view_origin;  // the pixel where the image plane's (0, 0) is
  Vec2 move;                        // of the eye, in pixels at nearness 1
  float ahead;                      // the same, along the depth

 private:
  static ImagePlane Moved(const ImagePlane& p, Vec2 move, float ahead) {
    const float shrink = ahead == 0 ? 1.0f : 1 / (1 - ahead * p.nearness);
    const float turn =
        1 - glm::dot(p.gradient, move) - ahead * (p.nearness - glm::dot(p.gradient, p.at));
    return {.at = (p.at - p.nearness * move) * shrink,
            .nearness = p.nearness * shrink,
            .gradient = p.gradient / turn};
  }
};

}  // namespace penumbra
