// Where segments meet a mesh, triangle by triangle and in double precision.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "render/technique/shadow_volume/template_mesh.h"

namespace penumbra::testing {

// How often the segment meets the mesh, and with what sign; nullopt where rounding may decide.
struct Crossings {
  int all = 0, in = 0;
};
inline std::optional<Crossings> CrossingsOf(const VolumeTriangles& mesh, DVec3 from, DVec3 to) {
  Crossings crossings;
  const DVec4 p(from, 1), way(to - from, 0);
  for (size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    const DVec4 a(mesh.vertices[mesh.indices[i]]), b(mesh.vertices[mesh.indices[i + 1]]),
        c(mesh.vertices[mesh.indices[i + 2]]);
    // p + t · way = u a + v b + w c, up to a factor.
    const auto det = [](DVec4 q, DVec4 r, DVec4 s, DVec4 t) {
      return glm::determinant(DMat4(q, r, s, t));
    };
    const double at_p = det(p, a, b, c), at_way = det(way, a, b, c);
    const double u = det(p, way, b, c), v = det(p, way, c, a), w = det(p, way, a, b);
    const double size = std::abs(u) + std::abs(v) + std::abs(w);
    const double least = std::min({u, v, w}), most = std::max({u, v, w});
    if (least < -1e-9 * size && most > 1e-9 * size) continue;
    const double t = -at_p / at_way;
    if (std::min(std::abs(least), std::abs(most)) <= 1e-9 * size) return std::nullopt;
    if (std::abs(t) < 1e-9 || std::abs(t - 1) < 1e-9) return std::nullopt;
    if (!(t > 0 && t < 1)) continue;
    ++crossings.all;
    crossings.in += u > 0 ? 1 : -1;
  }
  return crossings;
}

}  // namespace penumbra::testing
