#include "render/technique/shadow_volume/edge_thresholds.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace penumbra {
namespace {

constexpr int kBinBits = 23 - 2;  // of a float, that a bin does not tell apart
constexpr int kFirstBin = (127 - 64) << (23 - kBinBits);  // the bits of 2⁻⁶⁴
constexpr uint32_t kRowStep = 4;                          // of every so many rows one is looked at

using Histogram = std::array<uint32_t, kDifferenceBins>;

void Add(Histogram& histogram, const VolumeGrid& grid, float a, float b) {
  if (std::min(a, b) == grid.nothing()) return;  // an edge or none, whatever the thresholds
  ++histogram[DifferenceBin(std::abs(a - b) / grid.PixelWidth(std::max(a, b)))];
}

}  // namespace

int DifferenceBin(float difference) {
  if (!(difference > 0)) return 0;
  const int bin = static_cast<int>(std::bit_cast<uint32_t>(difference) >> kBinBits) - kFirstBin;
  return std::clamp(bin, 0, kDifferenceBins - 1);
}

float DifferenceOfBin(int bin) {
  return std::bit_cast<float>(static_cast<uint32_t>(bin + kFirstBin) << kBinBits);
}

EdgeThresholds ChooseThresholds(const VolumeGrid& grid) {
  Histogram histogram{};
  for (uint32_t y = 0; y + 1 < grid.height(); y += kRowStep) {
    const float *row = grid.Row(y), *next = grid.Row(y + 1);
    for (uint32_t x = 0; x + 1 < grid.width(); ++x) {
      Add(histogram, grid, row[x], row[x + 1]);
      Add(histogram, grid, row[x], next[x]);
    }
  }
  const double most = kEdgesPerSide * (grid.width() + grid.height()) / kRowStep;
  double above = 0;
  int bin = kDifferenceBins;
  while (bin > 0 && above <= most) above += histogram[--bin];
  const double side = std::max(grid.width(), grid.height());
  const auto low = static_cast<float>(
      std::clamp(double{DifferenceOfBin(bin)}, kLeastGap * side, kMostGap * side));
  return {.low = low, .high = 4 * low};
}

}  // namespace penumbra
