// Which texels of a grid lie on a receiver that does not fill its patch.
//
//   auto mask = CoverRegion(*receiver.region, receiver.width, receiver.height);
//   if (mask && !mask->At(i, j)) …   // null: all of them do
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "render/math/vec.h"

namespace penumbra {

// The part of a patch that is the receiver: the union of simple polygons.
struct PlanarRegion {
  std::vector<DVec2> points;   // u, v of the patch
  std::vector<uint32_t> ends;  // of each polygon, one past its last point

  friend bool operator==(const PlanarRegion&, const PlanarRegion&) = default;

  void Add(std::span<const DVec2> polygon) {
    points.insert(points.end(), polygon.begin(), polygon.end());
    ends.push_back(static_cast<uint32_t>(points.size()));
  }
};

// One bit a texel. Texel k = j·width + i is bit k mod 8 of byte k div 8; 1: inside. Bits past the
// last texel are 0.
class CoverageMask {
 public:
  // Nothing is inside. Both sides > 0.
  CoverageMask(uint32_t width, uint32_t height)
      : width_(width), height_(height), bytes_((size_t{width} * height + 7) / 8) {}

  uint32_t width() const { return width_; }
  uint32_t height() const { return height_; }
  size_t texel_count() const { return size_t{width_} * height_; }
  bool At(uint32_t i, uint32_t j) const { return At(size_t{j} * width_ + i); }
  bool At(size_t texel) const { return (bytes_[texel / 8] >> (texel % 8) & 1) != 0; }
  size_t CountInside() const;

  void Set(size_t texel) { bytes_[texel / 8] |= static_cast<uint8_t>(1u << (texel % 8)); }
  std::span<const uint8_t> bytes() const { return bytes_; }
  std::span<uint8_t> mutable_bytes() { return bytes_; }

  friend bool operator==(const CoverageMask&, const CoverageMask&) = default;

 private:
  uint32_t width_, height_;
  std::vector<uint8_t> bytes_;
};

// How far from a region a texel's centre may lie and still count as inside, in texels: what single
// precision makes of an edge that two triangles share.
inline constexpr double kCoverageSlack = 1e-3;

// The texels whose centre lies in `region`, or the one in its middle where it holds no centre.
// Null: all of them.
//
// Cost  O(E·R + W·H) for polygons of E edges that reach over R rows
std::shared_ptr<const CoverageMask> CoverRegion(const PlanarRegion& region, uint32_t width,
                                                uint32_t height);

// A texel outside, and the one inside that stands in for it.
struct GutterTexel {
  uint32_t outside = 0;
  uint32_t inside = 0;  // j·width + i
};

// The texels outside that lie within `reach` ≤ 100 texels of one inside, each with the nearest, so
// that a filter which takes in texels outside takes in nothing foreign. Ties and, in rare corners,
// a texel that is a hundredth of a texel further are settled by the order of the sweeps.
//
// Cost    O(W·H), two bytes a texel
// Source  Danielsson 1980, sequential Euclidean distance mapping (8SED)
std::vector<GutterTexel> FindGutter(const CoverageMask& mask, int reach);

}  // namespace penumbra
