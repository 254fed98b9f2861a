#include "render/artifact/volume_grid.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace penumbra {
namespace {

// |a − b|, with which infinities that are equal do not differ.
double Difference(double a, double b) { return a == b ? 0.0 : std::abs(a - b); }

// The weighted sum of corners, where a corner without a weight does not count, whatever it is.
double Mix(const std::array<double, 3>& weights, const std::array<float, 3>& corners) {
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    if (weights[k] != 0) sum += weights[k] * double{corners[k]};
  }
  return sum;
}

}  // namespace

VolumeGrid::VolumeGrid(const DepthMap& map, VolumeBorder border, float bias_px)
    : from_infinity_(map.view.from_infinity), frame_(map.view.frame) {
  const LightView& view = map.view;
  if (view.empty() || map.depths.size() != size_t{view.width} * view.height) return;
  const uint32_t ring = border == VolumeBorder::kNothing ? 1 : 0;
  width_ = view.width + 2 * ring;
  height_ = view.height + 2 * ring;
  first_cell_ = ring ? 0 : kVolumeOverlap;
  const DVec2 step = 1.0 / view.pixels_per_slope();
  pixel_ = static_cast<float>(std::sqrt(step.x * step.y));
  first_at_ = DVec2(first_cell_);
  steps_ = glm::max(DVec2(width_ - 1, height_ - 1) - 2.0 * first_at_, DVec2(1.0));
  const DVec2 origin = view.window.min + (0.5 - ring) * step;  // of sample (0, 0)
  first_ = origin + first_at_ * step;
  last_ = origin + (first_at_ + steps_) * step;
  // Neighbours meet where slopes are ±1, which rounding must not move.
  if (border == VolumeBorder::kOthers) first_ = glm::round(first_), last_ = glm::round(last_);
  const Basis& axes = frame_.axes;
  is_right_handed_ = glm::dot(glm::cross(axes.s, axes.t), axes.n) < 0;
  eye_ = from_infinity_ ? view.eye : frame_.ToWorld(view.eye);
  const DVec4 at_zero = WorldAt(DVec2(0.0), 0.0);
  world_from_grid_ = DMat4(WorldAt(DVec2(1, 0), 0.0) - at_zero, WorldAt(DVec2(0, 1), 0.0) - at_zero,
                           WorldAt(DVec2(0.0), 1.0) - at_zero, at_zero);
  Fill(map, ring, double{bias_px} * pixel_);
}

void VolumeGrid::Fill(const DepthMap& map, uint32_t ring, double bias) {
  nearness_.assign(size_t{width_} * height_ + kReadPast, nothing());
  const auto scale = static_cast<float>(1 / (1 + bias)), shift = static_cast<float>(bias);
  for (uint32_t y = 0; y < map.view.height; ++y) {
    const float* depths = &map.depths[size_t{y} * map.view.width];
    float* row = &nearness_[size_t{y + ring} * width_ + ring];
    if (from_infinity_) {
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

bool VolumeGrid::SplitsAtOneThree(uint32_t x, uint32_t y) const {
  const float *near_row = Row(y) + x, *far_row = Row(y + 1) + x;
  return Difference(near_row[0], far_row[1]) > Difference(near_row[1], far_row[0]);
}

// So that it is exactly first_ and last_ at the ends, and the same on all grids that run between
// the same.
DVec2 VolumeGrid::SlopeAt(DVec2 place) const {
  const DVec2 along = place - first_at_;
  return (first_ * (steps_ - along) + last_ * along) / steps_;
}

DVec4 VolumeGrid::WorldAt(DVec2 place, double nearness) const {
  const DVec2 at = SlopeAt(place);
  const Basis& axes = frame_.axes;
  if (!from_infinity_) {
    return DVec4(at.x * axes.s + at.y * axes.t + axes.n + nearness * eye_, nearness);
  }
  const DVec3 away = axes.n - eye_.x * axes.s - eye_.y * axes.t;  // a metre deeper
  if (std::isinf(nearness)) return DVec4(away, 0.0);
  return DVec4(frame_.origin + at.x * axes.s + at.y * axes.t - nearness * away, 1.0);
}

VolumeGrid::Place VolumeGrid::PlaceOf(DVec3 world) const {
  const DVec3 q =
      from_infinity_ ? frame_.FromWorld(world) : frame_.DirectionFromWorld(world - eye_);
  const DVec2 slope = from_infinity_ ? DVec2(q) + q.z * DVec2(eye_) : DVec2(q) / q.z;
  const DVec2 at = first_at_ + (slope - first_) / (last_ - first_) * steps_;
  return {
      .at = at, .nearness = from_infinity_ ? -q.z : 1 / q.z, .is_ahead = from_infinity_ || q.z > 0};
}

bool VolumeGrid::Covers(DVec2 place) const {
  return has_cells() && place.x >= first_cell_ && place.y >= first_cell_ &&
         place.x <= end_cell_x() && place.y <= end_cell_y();
}

double VolumeGrid::NearnessAt(DVec2 place) const {
  if (!Covers(place)) return nothing();
  const uint32_t x = std::min(static_cast<uint32_t>(place.x), end_cell_x() - 1);
  const uint32_t y = std::min(static_cast<uint32_t>(place.y), end_cell_y() - 1);
  const double u = place.x - x, v = place.y - y;
  const float *near_row = Row(y) + x, *far_row = Row(y + 1) + x;
  if (SplitsAtOneThree(x, y)) {
    if (u + v <= 1) return Mix({1 - u - v, u, v}, {near_row[0], near_row[1], far_row[0]});
    return Mix({u + v - 1, 1 - v, 1 - u}, {far_row[1], near_row[1], far_row[0]});
  }
  if (u >= v) return Mix({1 - u, u - v, v}, {near_row[0], near_row[1], far_row[1]});
  return Mix({1 - v, u, v - u}, {near_row[0], far_row[1], far_row[0]});
}

}  // namespace penumbra
