// Vertices that stand at one place.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/math/vec.h"

namespace penumbra {

// For each vertex, one vertex at the same position: the same one for all of them. Files give a
// vertex several normals or texture coordinates by repeating it; to shadows it is one.
//
// Shapes  V positions → V indices < V
// Cost    O(V log V)
std::vector<uint32_t> WeldByPosition(std::span<const Vec3> positions);

}  // namespace penumbra
