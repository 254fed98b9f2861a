// All triangles of a scene that can block light, in world space and double precision.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "render/math/vec.h"
#include "render/scene/scene.h"

namespace penumbra {

struct OccluderTriangle {
  std::array<DVec3, 3> corners;
  std::array<DVec2, 3> uvs{};                // where `masked` is set
  std::shared_ptr<const Instance> masked{};  // has an alpha mask; null: opaque
};

// In the order of instances and of their triangles, those of no area included.
std::vector<OccluderTriangle> OccluderTriangles(const Scene& scene);

// Whether a masked instance is there at `uv`.
bool MaskBlocks(const Instance& instance, DVec2 uv);

}  // namespace penumbra
