// Whether a mesh bounds a solid.
#pragma once

#include <cstdint>
#include <span>

#include "render/math/vec.h"

namespace penumbra {

enum class MeshClosure {
  kOpen,           // some edge does not join two faces of the same orientation
  kClosed,         // no boundary, but some part is turned inside out
  kClosedOutward,  // no boundary, and each connected part has its faces to the outside
};

// Vertices at equal positions are taken as one; faces that repeat a vertex are left out.
//
// On any line from a light, a closed mesh's faces towards the light cover just what its faces away
// from it do, so either half casts the whole shadow.
//
// Shapes  V positions, 3T indices < V
// Cost    O(T log T)
MeshClosure FindClosure(std::span<const Vec3> positions, std::span<const uint32_t> indices);

}  // namespace penumbra
