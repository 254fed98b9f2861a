// Where on the light's square samples are.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "render/math/random.h"
#include "render/technique/coherent_raytrace/cell_mask.h"
#include "render/technique/coherent_raytrace/sampler_kernel.h"

namespace penumbra {

// The key of a point's samples.
inline uint64_t SampleSeed(uint64_t seed, uint64_t point_index) {
  return MixBits(MixBits(seed) ^ point_index);
}

// Some samples of one point or, one after another, of several.
//
//   SampleBatch samples;
//   samples.Add(cells, grid, seed);  // u, v and part of each cell's sample are known
struct SampleBatch {
  static constexpr size_t kMax = size_t{CellMask::kMaxSide} * CellMask::kMaxSide;

  // At most kMax in all.
  //
  // sample_seed  the point's SampleSeed
  [[gnu::always_inline]] void Add(const CellMask& cells, const CellGrid& grid,
                                  uint64_t sample_seed) {
    const size_t first = count;
    cells.ForEach([&](uint32_t its_cell) { cell[count++] = its_cell; });
    PlaceSamples(grid, sample_seed, &cell[first], count - first,
                 {&u[first], &v[first], &part[first]});
  }

  size_t count = 0;
  std::array<uint32_t, kMax + kSamplerLanes> cell;
  std::array<float, kMax + kSamplerLanes> u, v;
  std::array<uint32_t, kMax + kSamplerLanes> part;
};

}  // namespace penumbra
