// Between the unit square and the unit disc, area for area.
//
// Source  Shirley and Chiu 1997, concentric map
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/math/vec.h"

namespace penumbra {

// From [0, 1]² to the disc of radius 1 about the origin.
inline DVec2 ConcentricDisk(DVec2 square) {
  constexpr double kPi = std::numbers::pi;
  const DVec2 p = 2.0 * square - 1.0;
  if (p.x == 0 && p.y == 0) return DVec2(0.0);
  const bool wide = std::abs(p.x) > std::abs(p.y);
  const double radius = wide ? p.x : p.y;
  const double angle = wide ? kPi / 4 * (p.y / p.x) : kPi / 2 - kPi / 4 * (p.x / p.y);
  return radius * DVec2(std::cos(angle), std::sin(angle));
}

// Back: the point of the square that ConcentricDisk takes to `disk`; outside of the square for a
// point outside of the disc.
inline DVec2 ConcentricSquare(DVec2 disk) {
  constexpr double kQuarter = std::numbers::pi / 4;
  const double radius = glm::length(disk);
  if (radius == 0) return DVec2(0.5);
  const bool wide = std::abs(disk.x) > std::abs(disk.y);
  const double along = std::copysign(radius, wide ? disk.x : disk.y);
  const double across = wide ? along / kQuarter * std::atan(disk.y / disk.x)
                             : along / kQuarter * std::atan(disk.x / disk.y);
  return 0.5 * (wide ? DVec2(along, across) : DVec2(across, along)) + 0.5;
}

}  // namespace penumbra
