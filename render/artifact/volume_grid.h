// The samples of a depth map with how near they are, ready to be gone through.
//
//   const VolumeGrid grid(map, border, bias_px);
//   grid.WorldAt(x, y)      // a corner, homogeneous
//   grid.NearnessAt(place)  // of the surface, anywhere between
#pragma once

#include <cstdint>
#include <vector>

#include "render/artifact/depth_map.h"
#include "render/artifact/volume_frame.h"

namespace penumbra {

// How many floats past the end of a row may be read.
inline constexpr size_t kReadPast = 80;

// One corner of a cell: a sample.
struct GridCorner {
  uint32_t x, y;
};

class VolumeGrid : public VolumeFrame {
 public:
  // bias_px  how far behind the samples the surface is, in pixels' widths there: ≥ 0
  VolumeGrid(const DepthMap& map, VolumeBorder border, float bias_px);

  // Where nothing is seen, and where the depth is not a number or not before the light: nothing().
  float At(uint32_t x, uint32_t y) const { return nearness_[size_t{y} * width_ + x]; }
  void Set(uint32_t x, uint32_t y, float nearness) { nearness_[size_t{y} * width_ + x] = nearness; }
  const float* Row(uint32_t y) const { return &nearness_[size_t{y} * width_]; }

  CellCorners CornersOf(uint32_t x, uint32_t y) const {
    const float *near_row = Row(y) + x, *far_row = Row(y + 1) + x;
    return {near_row[0], near_row[1], far_row[1], far_row[0]};
  }
  bool SplitsAtOneThree(uint32_t x, uint32_t y) const {
    return penumbra::SplitsAtOneThree(CornersOf(x, y));
  }

  using VolumeFrame::WorldAt;
  DVec4 WorldAt(uint32_t x, uint32_t y) const { return WorldAt(DVec2(x, y), At(x, y)); }

  // Of the surface; nothing() where it is not told of.
  double NearnessAt(DVec2 place) const;

 private:
  void Fill(const DepthMap& map, float bias_px);

  std::vector<float> nearness_;
};

}  // namespace penumbra
