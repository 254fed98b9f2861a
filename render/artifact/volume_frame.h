// Where the samples of a depth map are, as the corners of a surface: what is lit lies before it,
// what is in shadow behind.
//
//   const VolumeFrame frame(map.view, border);
//   frame.PlaceOf(world)         // and back:
//   frame.WorldAt(place, nearness)
//
// Nearness r grows towards the light: it is 1/depth, from infinitely far −depth. In (x, y, r) light
// comes along −r, the surface is a height over (x, y), and what is plane in the world is plane.
#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "render/artifact/light_view.h"
#include "render/math/vec.h"

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

class VolumeFrame {
 public:
  // Of an empty view there are no samples.
  VolumeFrame(const LightView& view, VolumeBorder border);

  // Samples, those of the ring included; 0: there are none.
  uint32_t width() const { return width_; }
  uint32_t height() const { return height_; }
  // How many rings of samples around the map there are: 0 or 1.
  uint32_t ring() const { return ring_; }
  bool from_infinity() const { return from_infinity_; }
  // Cells [first_cell(), width() − 1 − first_cell()) × … have a surface in them.
  uint32_t first_cell() const { return first_cell_; }
  uint32_t end_cell_x() const { return width_ > first_cell_ ? width_ - 1 - first_cell_ : 0; }
  uint32_t end_cell_y() const { return height_ > first_cell_ ? height_ - 1 - first_cell_ : 0; }
  bool has_cells() const { return first_cell_ < end_cell_x() && first_cell_ < end_cell_y(); }

  float nothing() const { return from_infinity_ ? -std::numeric_limits<float>::infinity() : 0.0f; }
  // Of a sample; where its depth is not a number or not before the light, nothing().
  //
  // bias_px  how far behind the sample the surface is, in pixels' widths there: ≥ 0
  float NearnessOf(float depth, float bias_px) const;
  // A pixel's width where nearness is `r`, in terms of nearness.
  float PixelWidth(float r) const { return from_infinity_ ? pixel_ : pixel_ * r; }
  // The same of a pixel where r is 1: slope, or metres, a pixel.
  float pixel() const { return pixel_; }

  // Homogeneous; w = 0 where nearness is nothing(). (x, y) of a sample is that of its grid: (0, 0)
  // the first, in the ring or the overlap.
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
  // The first of the four samples around a place that is covered, and how far it is from there.
  struct Cell {
    uint32_t x, y;
    DVec2 within;
  };
  Cell CellAt(DVec2 place) const;

 protected:
  uint32_t width_ = 0, height_ = 0, first_cell_ = 0, ring_ = 0;

 private:
  DVec2 SlopeAt(DVec2 place) const;

  bool from_infinity_ = false;
  bool is_right_handed_ = true;
  float pixel_ = 0;
  DVec2 first_{0.0}, last_{0.0};      // image places of the outermost corners of cells
  DVec2 first_at_{0.0}, steps_{1.0};  // in the grid: where the first is, and how far the last
  LightFrame frame_;
  DVec3 eye_{0.0};  // world space; from infinitely far LightView's
  DMat4 world_from_grid_{1.0};
};

// Nearness of the four corners of a cell: 0, 1, 2, 3 are at (x, y), (x + 1, y), (x + 1, y + 1),
// (x, y + 1).
using CellCorners = std::array<float, 4>;

// Whether the cell's diagonal runs from corner 1 to corner 3, and not from 0 to 2: across the
// greater of the two differences.
//
// Source  McCool 2000, §4
bool SplitsAtOneThree(const CellCorners& corners);
// Of the surface at `within`, in [0, 1]²: linear between the corners of the cell's triangles.
double NearnessWithin(const CellCorners& corners, DVec2 within);

}  // namespace penumbra
