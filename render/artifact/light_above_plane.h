// How much of a light is in front of a surface.
//
//   visible = std::min(visible, LightAbovePlane(light, point, normal));
#pragma once

#include "render/math/vec.h"
#include "render/scene/area_light.h"

namespace penumbra {

// The fraction of `light` that a small surface at `point` has on the side of `normal`, were nothing
// between, in [0, 1]: of a rectangle's or disk's area, of the disc that shows of a sphere, of a
// distant light's disc as projected on a surface that faces it. 0 behind a light that shines from
// its front alone; a spot's cone is not asked for.
//
// normal  of length 1
// Cost    closed form, about 50 ns
float LightAbovePlane(const AreaLight& light, Vec3 point, Vec3 normal);

// The parts of it, each in closed form and in [0, 1].
//
// The share of the unit square where a + b·s + c·t > 0.
double SquareAbove(double a, double b, double c);
// The share of a disc of radius 1 within `d` of its centre or beyond, to one side: x > −d.
double DiscAbove(double d);
// The share of the directions around an axis whose sine is below `sin_radius`, weighed by their
// cosine, that are above a plane over which the axis rises by `sin_height`.
double SkyDiscAbove(double sin_radius, double sin_height);

}  // namespace penumbra
