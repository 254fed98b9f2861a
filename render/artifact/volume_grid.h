// The samples of a depth map as the corners of a surface: what is lit lies before it, what is in
// shadow behind.
//
//   const VolumeGrid grid(map, border, bias_px);
//   grid.WorldAt(x, y)      // a corner, homogeneous
//   grid.NearnessAt(place)  // of the surface, anywhere between
//
// Nearness r grows towards the light: it is 1/depth, from infinitely far −depth. In (x, y, r) light
// comes along −r, the surface is a height over (x, y), and what is plane in the world is plane.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "render/artifact/depth_map.h"

namespace penumbra {

// What is beyond the samples of a map.
enum class VolumeBorder : uint8_t {
  // Light: a ring of samples around the map sees nothing, so that the surface closes there.
  kNothing,
  // Other maps, that go on where this one ends: the surface ends at its outermost samples but
  // kVolumeOverlap, which are there to tell edges near the border from slopes, as the neighbour
  // would.
  kOthers,
};
inline constexpr uint32_t kVolumeOverlap = 2;

// How many floats past the end of a row may be read.
inline constexpr size_t kReadPast = 80;

// One corner of a cell: a sample. A cell's corners 0, 1, 2, 3 are at (x, y), (x + 1, y),
// (x + 1, y + 1), (x, y + 1).
struct GridCorner {
  uint32_t x, y;
};

class VolumeGrid {
 public:
  // bias_px  how far behind the samples the surface is, in pixels' widths there: ≥ 0
  VolumeGrid(const DepthMap& map, VolumeBorder border, float bias_px);

  // Samples, those of the ring included; 0: there are none.
  uint32_t width() const { return width_; }
  uint32_t height() const { return height_; }
  bool from_infinity() const { return from_infinity_; }
  // Cells [first_cell(), width() − 1 − first_cell()) × … have a surface in them.
  uint32_t first_cell() const { return first_cell_; }
  uint32_t end_cell_x() const { return width_ > first_cell_ ? width_ - 1 - first_cell_ : 0; }
  uint32_t end_cell_y() const { return height_ > first_cell_ ? height_ - 1 - first_cell_ : 0; }
  bool has_cells() const { return first_cell_ < end_cell_x() && first_cell_ < end_cell_y(); }

  // Where nothing is seen, and where the depth is not a number or not before the light: nothing().
  float At(uint32_t x, uint32_t y) const { return nearness_[size_t{y} * width_ + x]; }
  void Set(uint32_t x, uint32_t y, float nearness) { nearness_[size_t{y} * width_ + x] = nearness; }
  const float* Row(uint32_t y) const { return &nearness_[size_t{y} * width_]; }
  float nothing() const { return from_infinity_ ? -std::numeric_limits<float>::infinity() : 0.0f; }
  // A pixel's width where nearness is `r`, in terms of nearness.
  float PixelWidth(float r) const { return from_infinity_ ? pixel_ : pixel_ * r; }
  // The same of a pixel where r is 1: slope, or metres, a pixel.
  float pixel() const { return pixel_; }

  // Whether the cell's diagonal runs from corner 1 to corner 3, and not from 0 to 2: across the
  // greater of the two differences.
  //
  // Source  McCool 2000, §4
  bool SplitsAtOneThree(uint32_t x, uint32_t y) const;

  // (x, y) of a sample is that of its grid: (0, 0) the first, in the ring or the overlap.
  DVec4 WorldAt(uint32_t x, uint32_t y) const { return WorldAt(DVec2(x, y), At(x, y)); }
  // Homogeneous; w = 0 where nearness is nothing().
  DVec4 WorldAt(DVec2 place, double nearness) const;
  // (x, y, nearness) of a point in world space, and whether the light looks that way at all.
  struct Place {
    DVec2 at;
    double nearness;
    bool is_ahead;
  };
  Place PlaceOf(DVec3 world) const;
  // (x, y, r, 1) → WorldAt(), for planes; as good as it but for rounding.
  const DMat4& world_from_grid() const { return world_from_grid_; }
  // Whether x, y, and the way to the light are a right-handed system in the world.
  bool is_right_handed() const { return is_right_handed_; }

  // Whether the surface is told of at `place`.
  bool Covers(DVec2 place) const;
  // Of the surface: linear between the corners of a cell's triangles; nothing() where it is not
  // told of.
  double NearnessAt(DVec2 place) const;

 private:
  DVec2 SlopeAt(DVec2 place) const;
  void Fill(const DepthMap& map, uint32_t ring, double bias);

  uint32_t width_ = 0, height_ = 0, first_cell_ = 0;
  bool from_infinity_ = false;
  bool is_right_handed_ = true;
  float pixel_ = 0;
  DVec2 first_{0.0}, last_{0.0};      // image places of the outermost corners of cells
  DVec2 first_at_{0.0}, steps_{1.0};  // in the grid: where the first is, and how far the last
  LightFrame frame_;
  DVec3 eye_{0.0};  // world space; from infinitely far LightView's
  DMat4 world_from_grid_{1.0};
  std::vector<float> nearness_;
};

}  // namespace penumbra
