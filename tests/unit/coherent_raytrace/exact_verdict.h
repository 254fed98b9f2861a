// Whether a ray is blocked: by every triangle in double precision.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "render/reference/occluder_triangles.h"

namespace penumbra {

struct Verdict {
  bool blocked = false;
  bool is_close = false;  // rounding may decide
};

// Of the ray from `origin` to origin + end · way, where `slack` is a distance in lengths of `way`
// and in barycentric coordinates.
inline Verdict Exact(const std::vector<OccluderTriangle>& triangles, DVec3 origin, DVec3 way,
                     double end, double slack) {
  Verdict verdict;
  for (const OccluderTriangle& triangle : triangles) {
    const auto& [a, b, c] = triangle.corners;
    const DVec3 e1 = b - a, e2 = c - a, normal = glm::cross(e1, e2);
    const double steep = glm::dot(normal, way), area2 = glm::dot(normal, normal);
    if (area2 < 1e-14 || std::abs(steep) < 1e-7 * std::sqrt(area2) * glm::length(way)) {
      verdict.is_close |= area2 >= 1e-14;
      continue;
    }
    const double t = glm::dot(normal, a - origin) / steep;
    const DVec3 p = origin + t * way - a;
    const double v = glm::dot(glm::cross(p, e2), normal) / area2;
    const double w = glm::dot(glm::cross(e1, p), normal) / area2;
    const double margin = std::min({v, w, 1 - v - w});
    if (margin < -slack || t < -slack || t > end + slack) continue;
    if (margin < slack || t < slack || std::abs(t - end) < slack || triangle.masked) {
      verdict.is_close = true;
    } else {
      verdict.blocked = true;
    }
  }
  return verdict;
}

}  // namespace penumbra
