// What is done for every sample; compiled for several instruction sets and chosen when first
// called.
#pragma once

#include <cstddef>
#include <cstdint>

#include "render/math/vec.h"

namespace penumbra {

// Arrays that samplers' kernels read or write are padded: they have room for this many more.
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

}  // namespace penumbra
