// What the sampler does for every cell and every blocker of a point, compiled for several
// instruction sets and chosen when first called.
#pragma once

#include <cstddef>
#include <cstdint>

#include "render/math/vec.h"

namespace penumbra {

// Arrays that the functions below write are padded to this many.
inline constexpr size_t kSamplerLanes = 16;

// A grid of side² cells, each divided into parts²; part (x, y) is number y · side · parts + x.
struct CellGrid {
  uint32_t side;   // 1 … 32
  uint32_t parts;  // 1 … 4
};

// The places of samples on the square and the parts that they are in, at 32·y + x of arrays of
// 1024.
struct SamplePlaces {
  float* u;
  float* v;
  int32_t* part;
};

// A sample's place in its cell is a function of the seed and the cell: 16 bits for each coordinate.
// All instruction sets give the same bits.
//
// Source  the finaliser is that of Wellons 2018, lowbias32
void PlaceSamples(const CellGrid& grid, uint64_t point_seed, const SamplePlaces& places);

// How a rectangle is seen from a point: LightSquare::Seen.
struct RectangleView {
  Vec3 point, normal, dual_u, dual_v;
  float height, along_u, along_v;
};

// The parts that blockers hide, or −1 for those that hide nothing of the light.
//
// Shapes  x, y, z of `count`, padded → part of `count`, padded
void PartsBehind(const CellGrid& grid, const RectangleView& view, const float* x, const float* y,
                 const float* z, size_t count, int32_t* part);

}  // namespace penumbra
