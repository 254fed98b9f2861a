// Form factors from a point with a normal to simple shapes, in closed form and double precision.
//
//   F = ∫ cos θ cos θ' / (π r²) dA'   over the part of the shape above the point's horizon
//
// A form factor is the share of the point's cosine-weighted hemisphere that the shape fills, so it
// lies in [0, 1]; times the shape's radiance it is the radiance that a white diffuse surface
// reflects.
#pragma once

#include <span>

#include "render/math/vec.h"

namespace penumbra {

// To the planar convex polygon `vertices` (3 to 128 of them, either way round), seen from `point`.
// Neither side of the polygon is special.
//
//   F = | 1/2π Σ_i β_i  n · (R_i × R_{i+1}) / |R_i × R_{i+1}| |
//
// with R_i from the point to vertex i and β_i the angle between R_i and R_{i+1}, after the polygon
// has been cut along the horizon.
//
// Source  Herf 1997, equation 4.2 (after Lambert); the cut at the horizon is ours
double PolygonFormFactor(std::span<const DVec3> vertices, DVec3 point, DVec3 normal);

// To the disc of `radius` about `center`, seen from `point`. Exact while the whole disc is above
// the horizon: the form factor is then n · Φ, with Φ the vector whose components along and across
// the disc's axis are the two textbook configurations (element parallel to a disc, element
// perpendicular to it). A disc that the horizon cuts is taken as a polygon of the same area with 96
// sides.
double DiskFormFactor(DVec3 center, DVec3 axis, double radius, DVec3 point, DVec3 normal);

// To a cap of directions around `cos_to_axis` = n · axis with half-angle α, given sin² α < 1: a
// sphere seen from outside (sin α = radius / distance) or a disc in the sky. Exact with and without
// a cut at the horizon.
double CapFormFactor(double cos_to_axis, double sin2_alpha);

}  // namespace penumbra
