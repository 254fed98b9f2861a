// Points strewn evenly over the unit square, in an order whose every prefix is even too.
#pragma once

#include <cstdint>
#include <vector>

#include "render/math/vec.h"

namespace penumbra {

// n points, one at a random place in each of n cells of equal area; cells come out roughly square
// where the unit square is `aspect` times as wide as it is high. The first k points tell an area
// about as well as a grid made for k does (light_sample_test).
//
// Shapes  n ≥ 1 → n points in [0, 1)²
// Cost    O(n²) at worst, O(n) where n is a power of 4
// Source  Herf 1997, §4.5.1, for the fixed jittered grid; Sobol' 1967 for the order
std::vector<DVec2> JitteredGrid(uint32_t n, double aspect, uint64_t seed);

}  // namespace penumbra
