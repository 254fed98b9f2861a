#include "render/artifact/volume_cap.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <variant>

#include "render/artifact/light_extent.h"
#include "render/artifact/near_plane.h"

namespace penumbra {
namespace {

// As a part of the distance to what the light sees next: as much as rounding allows.
constexpr double kLeastDistance = 1e-9;

// Cells [first, end).
struct CellRange {
  uint32_t first_x = 0, first_y = 0, end_x = 0, end_y = 0;
  bool holds_all = false;  // of what was asked for

  bool empty() const { return first_x >= end_x || first_y >= end_y; }
};

// The rectangle as homogeneous places (x, y, ·, w) of a grid, without what is behind the light.
std::vector<DVec4> OnGrid(const VolumeGrid& grid, const std::array<DVec3, 4>& rectangle,
                          bool& is_whole) {
  const DMat4 grid_from_world = glm::inverse(grid.world_from_grid());
  std::array<DVec4, 4> corners;
  double most = 0;
  for (size_t i = 0; i < 4; ++i) {
    corners[i] = grid_from_world * DVec4(rectangle[i], 1.0);
    most = std::max(most, std::abs(corners[i].w));
  }
  const double least = 1e-9 * most;
  std::vector<DVec4> ahead;
  is_whole = true;
  for (size_t i = 0; i < 4; ++i) {
    const DVec4 &a = corners[i], &b = corners[(i + 1) % 4];
    if (a.w >= least) ahead.push_back(a);
    is_whole = is_whole && a.w >= least;
    if ((a.w < least) != (b.w < least))
      ahead.push_back(glm::mix(a, b, (least - a.w) / (b.w - a.w)));
  }
  return ahead;
}

// The cells that the near plane's rectangle may hide from the light.
CellRange CellsBehind(const VolumeGrid& grid, const std::array<DVec3, 4>& rectangle) {
  CellRange range;
  const std::vector<DVec4> corners = OnGrid(grid, rectangle, range.holds_all);
  if (corners.empty()) return {};
  DVec2 low(INFINITY), high(-INFINITY);
  for (const DVec4& c : corners) {
    low = glm::min(low, DVec2(c) / c.w);
    high = glm::max(high, DVec2(c) / c.w);
  }
  const DVec2 first(grid.first_cell()), end(grid.end_cell_x(), grid.end_cell_y());
  range.holds_all =
      range.holds_all && low.x >= first.x && low.y >= first.y && high.x <= end.x && high.y <= end.y;
  const DVec2 from = glm::clamp(glm::floor(low), first, end);
  const DVec2 to = glm::clamp(glm::ceil(high), first, end);
  range.first_x = static_cast<uint32_t>(from.x), range.first_y = static_cast<uint32_t>(from.y);
  range.end_x = static_cast<uint32_t>(to.x), range.end_y = static_cast<uint32_t>(to.y);
  return range;
}

// What a sample is to the near plane.
enum Side : uint8_t {
  kBeyond,   // no shadow on it
  kBefore,   // one
  kRunsOff,  // before it, but its light never reaches the plane
};

class CellCapper {
 public:
  CellCapper(const VolumeGrid& grid, const NearPlane& plane, std::vector<Vec4>& corners)
      : grid_(grid),
        plane_(plane),
        on_grid_(plane.toward_light() * grid.world_from_grid()),
        corners_(corners) {}

  void CapRow(uint32_t y, const CellRange& range) {
    if (next_row_ != y) sides_[1] = SidesOf(y, range);
    sides_[0] = std::move(sides_[1]);
    sides_[1] = SidesOf(y + 1, range);
    next_row_ = y + 1;
    uint32_t run = range.first_x;  // where the run of whole cells before x began
    for (uint32_t x = range.first_x; x < range.end_x; ++x) {
      const size_t i = x - range.first_x;
      const int sum = sides_[0][i] + sides_[0][i + 1] + sides_[1][i] + sides_[1][i + 1];
      const bool is_whole = sides_[0][i] == kBefore && sides_[0][i + 1] == kBefore &&
                            sides_[1][i] == kBefore && sides_[1][i + 1] == kBefore;
      if (is_whole) continue;
      all_before_ = false;
      AddRun(run, x, y);
      run = x + 1;
      if (sum != 4 * kBeyond && sum != 4 * kRunsOff) AddCell(x, y);
    }
    AddRun(run, range.end_x, y);
  }

  bool all_before() const { return all_before_; }

 private:
  std::vector<uint8_t> SidesOf(uint32_t y, const CellRange& range) const {
    std::vector<uint8_t> sides;
    const DVec4& p = on_grid_;
    for (uint32_t x = range.first_x; x <= range.end_x; ++x) {
      const float nearness = grid_.At(x, y);
      const double level = p.x * x + p.y * y + p.w;
      if (!std::isfinite(nearness) || !(level + p.z * nearness >= 0)) {
        sides.push_back(kBeyond);
      } else {
        sides.push_back(grid_.from_infinity() || level < 0 ? kBefore : kRunsOff);
      }
    }
    return sides;
  }

  void AddRun(uint32_t first, uint32_t end, uint32_t y) {
    if (first >= end) return;
    const std::array<DVec4, 4> corners = {grid_.WorldAt(first, y), grid_.WorldAt(end, y),
                                          grid_.WorldAt(end, y + 1), grid_.WorldAt(first, y + 1)};
    plane_.AddWholeCap(corners, corners_);
  }

  void AddCell(uint32_t x, uint32_t y) {
    const std::array<GridCorner, 4> at = {GridCorner{x, y}, {x + 1, y}, {x + 1, y + 1}, {x, y + 1}};
    constexpr int kCorners[2][2][3] = {{{0, 1, 2}, {2, 3, 0}}, {{0, 1, 3}, {2, 3, 1}}};
    for (const auto& corners : kCorners[grid_.SplitsAtOneThree(x, y)]) {
      std::array<DVec4, 3> world;
      bool is_there = true, is_near = false;
      for (size_t k = 0; k < 3; ++k) {
        const GridCorner& corner = at[static_cast<size_t>(corners[k])];
        world[k] = grid_.WorldAt(corner.x, corner.y);
        // Where rays are parallel such a triangle is a wall along them.
        is_there = is_there && std::isfinite(grid_.At(corner.x, corner.y));
        is_near = is_near || grid_.At(corner.x, corner.y) != grid_.nothing();
      }
      if (is_there && is_near) plane_.AddCap(world, corners_);
    }
  }

  const VolumeGrid& grid_;
  const NearPlane& plane_;
  const DVec4 on_grid_;  // NearPlane::Before of (x, y, r, 1)
  std::vector<Vec4>& corners_;
  std::array<std::vector<uint8_t>, 2> sides_;
  uint32_t next_row_ = ~uint32_t{0};
  bool all_before_ = true;
};

}  // namespace

VolumeCapper::VolumeCapper(const ShadowVolume& volume, float bias_px, const AreaLight& light)
    : volume_(volume), light_(PlaceOfMiddle(light)) {
  for (const VolumeFace& face : volume.faces) {
    grids_.emplace_back(face.map, face.border, bias_px);
    const VolumeGrid& grid = grids_.back();
    double nearest = 0;
    for (uint32_t y = 0; y < grid.height(); ++y) {
      for (uint32_t x = 0; x < grid.width(); ++x) {
        nearest = std::max(nearest, double{grid.At(x, y)});
      }
    }
    nearest_.push_back(grid.from_infinity() || nearest <= 0 ? 1.0 : nearest);
  }
}

VolumeCaps VolumeCapper::CapsFor(const DMat4& clip_from_world, double near) const {
  VolumeCaps caps;
  bool all_before = true, any = false;
  for (size_t i = 0; i < grids_.size(); ++i) {
    const VolumeGrid& grid = grids_[i];
    if (!grid.has_cells()) continue;
    const NearPlane plane(clip_from_world, near, light_, kLeastDistance / nearest_[i]);
    const CellRange range = CellsBehind(grid, plane.rectangle());
    const bool ends_here = volume_.faces[i].border == VolumeBorder::kNothing;
    all_before = all_before && (range.holds_all || !ends_here);
    if (range.empty()) continue;
    any = true;
    caps.tested_samples +=
        size_t{range.end_x - range.first_x + 1} * (range.end_y - range.first_y + 1);
    CellCapper capper(grid, plane, caps.corners);
    for (uint32_t y = range.first_y; y < range.end_y; ++y) capper.CapRow(y, range);
    all_before = all_before && capper.all_before();
  }
  if (any && all_before) {
    caps.inverts = true;
    caps.corners.clear();
  }
  if (volume_.caster_indices.empty()) return caps;
  const NearPlane plane(clip_from_world, near, light_, kLeastDistance);
  for (size_t i = 0; i + 2 < volume_.caster_indices.size(); i += 3) {
    std::array<DVec4, 3> world;
    for (size_t k = 0; k < 3; ++k) world[k] = volume_.vertices[volume_.caster_indices[i + k]];
    plane.AddCap(world, caps.corners);
  }
  return caps;
}

}  // namespace penumbra
