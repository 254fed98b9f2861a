// A closed mesh of any number of faces, smooth with detail.
#pragma once

#include <cmath>
#include <numbers>

#include "render/scene/mesh.h"

namespace penumbra::testing {

// A torus of radii 1 and 0.3 m with ripples: 2 · `around` · `across` triangles.
inline MeshGeometry RippledTorus(uint32_t around, uint32_t across) {
  MeshGeometry torus;
  for (uint32_t i = 0; i < around; ++i) {
    for (uint32_t j = 0; j < across; ++j) {
      const float u = 2 * std::numbers::pi_v<float> * i / around;
      const float v = 2 * std::numbers::pi_v<float> * j / across;
      const float r = 0.3f + 0.03f * std::sin(17 * u) * std::cos(9 * v);
      torus.positions.emplace_back((1 + r * std::cos(v)) * std::cos(u), r * std::sin(v),
                                   (1 + r * std::cos(v)) * std::sin(u));
      const uint32_t a = i * across + j, b = i * across + (j + 1) % across;
      const uint32_t c = (i + 1) % around * across + j;
      const uint32_t d = (i + 1) % around * across + (j + 1) % across;
      torus.indices.insert(torus.indices.end(), {a, b, c, b, d, c});
    }
  }
  return torus;
}

}  // namespace penumbra::testing
