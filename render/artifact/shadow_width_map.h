// Soft shadows from a single light sample: a depth map, and how deep in shadow each texel is.
//
//   float visible = Visibility(map, point, normal);   // from any viewpoint, on any surface
#pragma once

#include <optional>
#include <vector>

#include "render/artifact/depth_map.h"
#include "render/artifact/light_view.h"
#include "render/math/vec.h"
#include "render/scene/area_light.h"

namespace penumbra {

// How much of a light a point in shadow gets, in [0, 1]:
//
//   I = 1 + c_bias − c_scale · sw / sd      where sd > 0, cut to [0, 1]; 1 where sd ≤ 0 or sw ≤ 0
//
// shadow_depth  sd: how far behind its blocker the point is, in m
// shadow_width  sw: how far from a point that is lit, in m; ∞ is far
// c_scale       ≥ 0: large values make penumbras narrow; ∞: none
// c_bias        ≥ 0: the width, as a part of the penumbra, that is lit besides the outline
// Source        Kirsch and Döllner 2003, §3
double Attenuation(double shadow_depth, double shadow_width, double c_scale, double c_bias);

// H×W texels as the face's view has them.
struct ShadowWidthLayer {
  std::vector<float> depths;  // of what blocks the light, in m as the view measures; kNoDepth where
                              // nothing does
  std::vector<float> widths;  // to the nearest texel that is lit, or outside of the blocker's own
                              // outline, on the image: slopes, from infinitely far metres; 0 where
                              // lit, ∞ where no texel is
};

struct ShadowWidthFace {
  LightView view;  // its eye is the frame's origin
  // The part of the view's window that the face tells of: with several faces a view sees more than
  // that, for shadows that reach across the border.
  Window window;
  ShadowWidthLayer near;
  // Further blockers, each behind a surface that itself is in the shadow of the first layer's. None
  // where the map has one layer.
  std::optional<ShadowWidthLayer> far;
};

struct ShadowWidthMap {
  AreaLight light;
  std::vector<ShadowWidthFace> faces;  // the first that has a point in its window tells of it
  // Of Attenuation; none: such that a straight edge's penumbra is as wide as that of the light.
  std::optional<float> c_scale;
  float c_bias = 0.0f;
};

// What of the light a surface at `point` gets, in [0, 1].
//
// At each of the four texels around the point's place on a face's image, the surface is in shadow
// where its plane (plane_on_image.h) is deeper than the blocker, by more than its spread. sw is
// interpolated between all four, with 0 where there is no shadow; the blocker's nearness between
// those alone that are in shadow, since of others there is none (the paper's open problem). Behind
// blockers of two layers it is the darker shadow that counts; a texel that has one blocker goes
// with those of the layer that its depth is like. c_scale is at most what makes a penumbra as wide
// as a texel is, so that hard shadows are as smooth as the map can tell.
//
// Of a light that has a size, and where the map says nothing else, c_scale is z / W, where z is the
// blocker's depth, from infinitely far 1, and W how wide the light is (light_width.h) in the
// direction in which sw grows. Then
//
//   c_scale · sw / sd  =  w / (W · (r₁ − r₂))
//
// with w as the map has it: the whole penumbra lies within the outline that the middle of the light
// casts.
//
// No more is returned than LightAbovePlane() is: behind a light that shines from its front alone 0.
//
// normal  of length 1
// Source  Kirsch and Döllner 2003, §3 to 5; departs: c_scale by the light, filter, self-shadowing
float Visibility(const ShadowWidthMap& map, Vec3 point, Vec3 normal);

}  // namespace penumbra
