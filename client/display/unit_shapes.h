// Meshes of the shapes that lights and receivers have.
#pragma once

#include <memory>

#include "render/scene/mesh.h"

namespace penumbra {

// Two triangles over [0, 1]² in x and y; the front is +z.
std::shared_ptr<const Mesh> UnitSquare();
// Of radius 1 in x and y, 96 sides; the front is +z.
std::shared_ptr<const Mesh> UnitDisk();
// Of radius 1 about the origin, front outwards.
std::shared_ptr<const Mesh> UnitSphere();

}  // namespace penumbra
