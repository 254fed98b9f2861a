// What is done for every sample and for every blocker, compiled for several
// instruction sets and chosen when first called.
#pragma once

#include <cstddef>
#include <cstdint>

#include "render/math/vec.h"

namespace penumbra {

// Arrays that the functions below write are padded to this many.
inline constexpr size_t kSamplerLanes = 16;

// A grid of side² cells, each divided into parts²; part (x, y) of all is number y · along() + x,
// and what is off the grid is in part along()².
struct CellGrid {
  uint32_t side;   // 1 … 32
  uint32_t parts;  // 1 … 4

  uint32_t along() const { return side * parts; }
  uint32_t off() const { return along() * along(); }
};

// The places of samples on the square and the parts that they are in.
struct SamplePlaces {
  float* u;
  float* v;
  uint32_t* part;
};

// The samples of one point in some cells, each a function of the point's seed and its cell,
// y · 32 + x: 16 bits for each coordinate of its place in the cell. All instruction sets give the
// same bits.
//
// Shapes  cell of `count`, padded → places of `count`, padded
// Source  the finaliser is that of Wellons 2018, lowbias32
void PlaceSamples(const CellGrid& grid, uint64_t sample_seed, const uint32_t* cell, size_t count,
                  const SamplePlaces& places);

// How a rectangle is seen from a point: LightSquare::Seen.
struct RectangleView {
  Vec3 point, normal, dual_u, dual_v;
  float height, along_u, along_v;
};

// The parts that blockers hide, or CellGrid::off for those that hide nothing of the light. Their
// last coordinates say nothing.
//
// Shapes  blockers of `count`, padded → part of `count`, padded
void PartsBehind(const CellGrid& grid, const RectangleView& view, const Vec4* blockers,
                 size_t count, uint32_t* part);

}  // namespace penumbra
