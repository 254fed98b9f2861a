#include "render/artifact/volume_grid.h"

#include <cmath>
#include <limits>

namespace penumbra {

VolumeGrid::VolumeGrid(const DepthMap& map, VolumeBorder border, float bias_px)
    : VolumeFrame(map.view, border) {
  if (map.depths.size() == size_t{map.view.width} * map.view.height) {
    if (width_ > 0) Fill(map, bias_px);
  } else {
    width_ = height_ = first_cell_ = 0;
  }
}

// As NearnessOf() has it, row by row.
void VolumeGrid::Fill(const DepthMap& map, float bias_px) {
  const double bias = double{bias_px} * pixel();
  const auto scale = static_cast<float>(1 / (1 + bias)), shift = static_cast<float>(bias);
  nearness_.assign(size_t{width_} * height_ + kReadPast, nothing());
  for (uint32_t y = 0; y < map.view.height; ++y) {
    const float* depths = &map.depths[size_t{y} * map.view.width];
    float* row = &nearness_[size_t{y + ring_} * width_ + ring_];
    if (from_infinity()) {
      for (uint32_t x = 0; x < map.view.width; ++x) {
        row[x] = std::isfinite(depths[x]) ? -(depths[x] + shift) : nothing();
      }
    } else {
      for (uint32_t x = 0; x < map.view.width; ++x) {
        row[x] = depths[x] > std::numeric_limits<float>::min() ? scale / depths[x] : 0.0f;
      }
    }
  }
}

double VolumeGrid::NearnessAt(DVec2 place) const {
  if (!Covers(place)) return nothing();
  const Cell cell = CellAt(place);
  return NearnessWithin(CornersOf(cell.x, cell.y), cell.within);
}

}  // namespace penumbra
