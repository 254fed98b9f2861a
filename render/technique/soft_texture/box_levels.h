// Which of many boxes can cast a shadow onto the texture from one light sample.
//
//   BoxLevels boxes(bounds);                      // once
//   boxes.Select(UnitBoxSides(map, window, height), found);   // for each sample
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "render/math/aabb.h"
#include "render/technique/soft_texture/coverage_kernel.h"
#include "render/technique/soft_texture/receiver_transform.h"

namespace penumbra {

// Half-spaces of offsets d from the receiver's origin, n·d + constant ≥ 0: in the unit box of the
// projective transform the planes x = 0, x = w, y = first row, y = last row, and w = 0.
struct UnitBoxSides {
  static constexpr size_t kCount = 5;

  // `window` is of a texture of `height` rows.
  UnitBoxSides(const ReceiverTransform& map, const TexelWindow& window, uint32_t height);

  float x[kCount], y[kCount], z[kCount], constant[kCount];
};

// What rounding may add to n·d + constant for a corner of a box, as a part of
// Σ |n| |d| + |constant|. Testing takes six operations and drawing about ten, each wrong by 2⁻²⁴ at
// most, and four times that is allowed: whatever is left out would not have set a bit.
inline constexpr double kUnitBoxSlack = 0x1.0p-18;

// Whether `box` is wholly outside one of the sides, by more than rounding.
bool MissesUnitBox(const Aabb& box, const UnitBoxSides& sides);

// Boxes in parallel arrays, and around each sixteen of them one of the next level. Immutable.
class BoxLevels {
 public:
  // Boxes to a parent: a vector of the widest instruction set.
  static constexpr size_t kChildren = kMaxLanes;

  // Middles and half sides, these widened by kUnitBoxSlack; padded to a multiple of kChildren.
  struct Level {
    std::vector<float> x, y, z, half_x, half_y, half_z;
    size_t count = 0;
  };

  BoxLevels() = default;
  // Neighbours in `boxes` should be neighbours in space. None is empty.
  explicit BoxLevels(std::span<const Aabb> boxes);

  // Sets `found` to the numbers of the boxes that are not wholly outside one of the sides, in
  // order.
  //
  // Source  Herf 1997, §4.4.1
  void Select(const UnitBoxSides& sides, std::vector<uint32_t>& found) const;

  size_t size() const { return levels_.empty() ? 0 : levels_.front().count; }

 private:
  std::vector<Level> levels_;
};

}  // namespace penumbra
