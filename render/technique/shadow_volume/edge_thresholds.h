// How different neighbours in a depth map are where a light's shadow has an edge.
//
//   const EdgeThresholds thresholds = ChooseThresholds(grid);
#pragma once

#include <cstdint>
#include <span>

#include "render/artifact/volume_grid.h"

namespace penumbra {

// Differences of nearness between neighbours, in pixels' widths: 1 is a surface that light meets at
// 45 degrees, or a step as high as the pixel is wide.
struct EdgeThresholds {
  float low = 1.0f;   // a candidate, which stands where the difference's own change says so
  float high = 8.0f;  // an edge in any case; where it is no more than `low` there are no candidates
  // What the change of the difference has to be for a candidate, and how much the difference is at
  // least near an edge that ends in the open, as parts of `low`.
  float second = 0.5f;
  float dangling = 0.5f;
};

inline constexpr float kMaxEdgeThreshold = 1e6f;

// Thresholds for a map whose surfaces nobody knows: `high` has as many differences above it as
// kEdgesPerSide times the map's sides, so that edges are as many as lines are and not as many as
// samples. It is kept between kLeastHigh, below which there are slopes, and kMostHigh, above which
// gaps would be seen that nobody looked for.
//
// Cost    a fourth of the differences are looked at
// Source  McCool 2000, §3.1
EdgeThresholds ChooseThresholds(const VolumeGrid& grid);
inline constexpr double kEdgesPerSide = 4.0;
inline constexpr float kLeastHigh = 4.0f;
inline constexpr float kMostHigh = 16.0f;

// How many of `differences` lie in each of the bins that DifferenceBin tells apart.
inline constexpr int kDifferenceBins = 512;

// Each power of two has four bins, from 2⁻⁶⁴ on; nothing and what is not a number are in the first,
// infinity is in the last.
int DifferenceBin(float difference);
// The least difference of a bin.
float DifferenceOfBin(int bin);

}  // namespace penumbra
