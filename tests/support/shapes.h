// Small meshes and receivers for tests.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "render/scene/mesh.h"
#include "render/scene/receiver.h"

namespace penumbra::testing {

inline std::shared_ptr<const Mesh> MeshOf(MeshGeometry geometry) {
  return Mesh::Create(std::move(geometry)).value();
}

// The closed box [-1, 1]³, its faces counter-clockwise seen from outside.
inline MeshGeometry UnitBoxGeometry() {
  MeshGeometry box;
  for (int corner = 0; corner < 8; ++corner) {
    box.positions.emplace_back((corner & 1) ? 1 : -1, (corner & 2) ? 1 : -1, (corner & 4) ? 1 : -1);
  }
  box.indices = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
  return box;
}

// The square [-1, 1]² in the plane y = 0, facing up, with uv from (0, 0) to (1, 1).
inline MeshGeometry UnitSquareGeometry() {
  return {.positions = {{-1, 0, 1}, {1, 0, 1}, {1, 0, -1}, {-1, 0, -1}},
          .indices = {0, 1, 2, 0, 2, 3},
          .normals = {},
          .uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
}

// The unit sphere in `around` sectors and `across` rings, its poles on the y axis. It is closed and
// its faces are counter-clockwise seen from outside. At the poles triangles have no area.
inline MeshGeometry BallGeometry(int around, int across) {
  MeshGeometry ball;
  for (int i = 0; i <= across; ++i) {
    const double b = std::numbers::pi * i / across;
    const double ring = i == 0 || i == across ? 0 : std::sin(b);
    for (int j = 0; j < around; ++j) {
      const double a = 2 * std::numbers::pi * j / around;
      ball.positions.emplace_back(ring * std::cos(a), std::cos(b), ring * std::sin(a));
    }
  }
  for (int i = 0; i < across; ++i) {
    for (int j = 0; j < around; ++j) {
      const auto a = static_cast<uint32_t>(i * around + j);
      const auto b = static_cast<uint32_t>(i * around + (j + 1) % around);
      const uint32_t c = a + around, d = b + around;
      ball.indices.insert(ball.indices.end(), {a, b, c, b, d, c});
    }
  }
  return ball;
}

inline Affine Placed(Vec3 position, float scale = 1.0f) {
  return Affine(Vec3(scale, 0, 0), Vec3(0, scale, 0), Vec3(0, 0, scale), position);
}

inline Affine Placed(Vec3 position, Vec3 scale) {
  return Affine(Vec3(scale.x, 0, 0), Vec3(0, scale.y, 0), Vec3(0, 0, scale.z), position);
}

// `side` metres square in the plane y = 0, centred, facing up.
inline Receiver FloorReceiver(std::string id, float side, uint32_t texels) {
  const float half = 0.5f * side;
  return {.id = std::move(id),
          .shape = Parallelogram{.origin = Vec3(-half, 0, half),
                                 .edge_u = Vec3(side, 0, 0),
                                 .edge_v = Vec3(0, 0, -side)},
          .width = texels,
          .height = texels};
}

}  // namespace penumbra::testing
