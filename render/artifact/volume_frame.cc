#include "render/artifact/volume_frame.h"

#include <algorithm>
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

VolumeFrame::VolumeFrame(const LightView& view, VolumeBorder border)
    : from_infinity_(view.from_infinity), frame_(view.frame) {
  if (view.empty()) return;
  ring_ = border == VolumeBorder::kNothing ? 1 : 0;
  width_ = view.width + 2 * ring_;
  height_ = view.height + 2 * ring_;
  first_cell_ = ring_ ? 0 : kVolumeOverlap;
  const DVec2 step = 1.0 / view.pixels_per_slope();
  pixel_ = static_cast<float>(std::sqrt(step.x * step.y));
  first_at_ = DVec2(first_cell_);
  steps_ = glm::max(DVec2(width_ - 1, height_ - 1) - 2.0 * first_at_, DVec2(1.0));
  const DVec2 origin = view.window.min + (0.5 - ring_) * step;  // of sample (0, 0)
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
}

float VolumeFrame::NearnessOf(float depth, float bias_px) const {
  const double bias = double{bias_px} * pixel_;
  if (from_infinity_) {
    return std::isfinite(depth) ? -(depth + static_cast<float>(bias)) : nothing();
  }
  const auto scale = static_cast<float>(1 / (1 + bias));
  return depth > std::numeric_limits<float>::min() ? scale / depth : 0.0f;
}

// So that it is exactly first_ and last_ at the ends, and the same on all grids that run between
// the same.
DVec2 VolumeFrame::SlopeAt(DVec2 place) const {
  const DVec2 along = place - first_at_;
  return (first_ * (steps_ - along) + last_ * along) / steps_;
}

DVec4 VolumeFrame::WorldAt(DVec2 place, double nearness) const {
  const DVec2 at = SlopeAt(place);
  const Basis& axes = frame_.axes;
  if (!from_infinity_) {
    return DVec4(at.x * axes.s + at.y * axes.t + axes.n + nearness * eye_, nearness);
  }
  const DVec3 away = axes.n - eye_.x * axes.s - eye_.y * axes.t;  // a metre deeper
  if (std::isinf(nearness)) return DVec4(away, 0.0);
  return DVec4(frame_.origin + at.x * axes.s + at.y * axes.t - nearness * away, 1.0);
}

VolumeFrame::Place VolumeFrame::PlaceOf(DVec3 world) const {
  const DVec3 q =
      from_infinity_ ? frame_.FromWorld(world) : frame_.DirectionFromWorld(world - eye_);
  const DVec2 slope = from_infinity_ ? DVec2(q) + q.z * DVec2(eye_) : DVec2(q) / q.z;
  const DVec2 at = first_at_ + (slope - first_) / (last_ - first_) * steps_;
  return {
      .at = at, .nearness = from_infinity_ ? -q.z : 1 / q.z, .is_ahead = from_infinity_ || q.z > 0};
}

bool VolumeFrame::Covers(DVec2 place) const {
  return has_cells() && place.x >= first_cell_ && place.y >= first_cell_ &&
         place.x <= end_cell_x() && place.y <= end_cell_y();
}

VolumeFrame::Cell VolumeFrame::CellAt(DVec2 place) const {
  const uint32_t x = std::min(static_cast<uint32_t>(place.x), end_cell_x() - 1);
  const uint32_t y = std::min(static_cast<uint32_t>(place.y), end_cell_y() - 1);
  return {x, y, place - DVec2(x, y)};
}

bool SplitsAtOneThree(const CellCorners& corners) {
  return Difference(corners[0], corners[2]) > Difference(corners[1], corners[3]);
}

double NearnessWithin(const CellCorners& corners, DVec2 within) {
  const double u = within.x, v = within.y;
  if (SplitsAtOneThree(corners)) {
    if (u + v <= 1) return Mix({1 - u - v, u, v}, {corners[0], corners[1], corners[3]});
    return Mix({u + v - 1, 1 - v, 1 - u}, {corners[2], corners[1], corners[3]});
  }
  if (u >= v) return Mix({1 - u, u - v, v}, {corners[0], corners[1], corners[2]});
  return Mix({1 - v, u, v - u}, {corners[0], corners[2], corners[3]});
}

}  // namespace penumbra
