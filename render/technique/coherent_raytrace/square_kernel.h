// Between the unit square that stands for a light and what a point sees of the light (LightSquare),
// for many samples or blockers at once; compiled for several instruction sets and chosen when first
// called.
#pragma once

#include <cstddef>
#include <cstdint>

#include "render/math/vec.h"
#include "render/technique/coherent_raytrace/sampler_kernel.h"

namespace penumbra {

// What a square stands for: a light's shape. That of a distant light with an extent is the sky.
enum class SquareKind { kRectangle, kDisk, kSphere, kSky, kPoint, kDirection };

// How a square is seen from a point. A place on the light is a pair (s, t): on a rectangle that of
// the square itself, else one on the disc of radius 1 that the concentric map makes of the square.
//
//   rectangle, disk   origin + s · u + t · v; n across both; the origin is the corner or the middle
//   sphere            origin + radius · (s · u + t · v − √(1 − s² − t²) · n); n towards its middle
//   sky               the direction radius · (s · u + t · v) + √(1 − radius² · (s² + t²)) · n
struct SquareView {
  SquareKind kind = SquareKind::kPoint;
  Vec3 point{0.0f};
  Vec3 origin{0.0f};
  Vec3 u{0.0f}, v{0.0f}, n{0.0f};        // n of length 1; of a sphere and of the sky u and v too
  Vec3 dual_u{0.0f}, dual_v{0.0f};       // dot(u, dual_u) = 1, across v: of rectangle and disk
  float height = 0.0f;                   // of the light's plane over the point, along n
  float along_u = 0.0f, along_v = 0.0f;  // the point's own place on the light's plane
  float radius = 0.0f;                   // of a sphere; of the sky the sine of half its angle
};

// All arrays below, those read too, are padded (kSamplerLanes). Two instruction sets differ by
// rounding: one has fused multiplications and another does not.

// The parts that blockers hide, or CellGrid::off for those that hide nothing of the light. Their
// last coordinates say nothing.
//
// Shapes  blockers of `count`, padded → part of `count`, padded
void PartsBehind(const SquareView& view, const CellGrid& grid, const Vec4* blockers, size_t count,
                 uint32_t* part);

// The positions of samples on the square, or of lights at infinity their unit directions.
//
// Shapes  u, v of `count`, padded → x, y, z of `count`, padded
void TargetsAt(const SquareView& view, size_t count, const float* u, const float* v, float* x,
               float* y, float* z);

// cos θ cos θ' / r² of equation (1), per area of the square, up to a factor that is the same all
// over the light; at places (s, t) on it.
//
// Shapes  s, t of `count`, padded → weight of `count`, padded
void WeightsAt(const SquareView& view, const Vec3& normal, size_t count, const float* s,
               const float* t, float* weight);

}  // namespace penumbra
