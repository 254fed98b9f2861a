// Balls and boxes of several sizes in a heap, each over or inside of others.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "render/scene/instance.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {

inline std::vector<Instance> PileOfThings() {
  std::vector<Instance> pile;
  for (int i = 0; i < 40; ++i) {
    const auto k = static_cast<float>(i);
    const Vec3 at(2 * std::sin(1.7f * k), 0.35f + 0.05f * k, 2 * std::cos(2.3f * k));
    pile.push_back({.id = "piece" + std::to_string(i),
                    .mesh = MeshOf(i % 3 == 0 ? BallGeometry(48, 24) : UnitBoxGeometry()),
                    .world_from_mesh = Placed(at, 0.12f + 0.01f * static_cast<float>(i % 7))});
  }
  return pile;
}

}  // namespace penumbra::testing
