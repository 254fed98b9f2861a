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
  float low = 2.0f;  // a candidate, which stands where the difference has a maximum
  float high =
      8.0f;  // an edge, but on a slope; no more than `low`: all that is above it is an edge
  // By how much a candidate exceeds what is beside it, and how much a difference is at least near
  // an edge that ends in the open, as parts of `low`.
  float second = 0.5f;
  float dangling = 0.25f;
};

// Thresholds for a map whose surfaces nobody knows. Gaps between surfaces are as high however many
// samples there are: `low` is a part of the map's longer side, between kLeastGap and kMostGap, and
// within these as low as leaves kEdgesPerSide times the map's sides of differences above it, so
// that edges are as many as lines are and not as many as samples. `high` is four times that.
//
// On scenes of penumbra_bench --suite shadow_volume half the gap gave 1.3 times the triangles and
// no better shadows; with twice the gap five times as many pixels were dark or lit that are further
// than two samples from any boundary.
//
// Cost    a fourth of the differences are looked at
// Source  McCool 2000, §3.1
EdgeThresholds ChooseThresholds(const VolumeGrid& grid);
inline constexpr double kEdgesPerSide = 16.0;
inline constexpr double kLeastGap = 1.0 / 256, kMostGap = 1.25 / 256;

// How many of `differences` lie in each of the bins that DifferenceBin tells apart.
inline constexpr int kDifferenceBins = 512;

// Each power of two has four bins, from 2⁻⁶⁴ on; nothing and what is not a number are in the first,
// infinity is in the last.
int DifferenceBin(float difference);
// The least difference of a bin.
float DifferenceOfBin(int bin);

}  // namespace penumbra
