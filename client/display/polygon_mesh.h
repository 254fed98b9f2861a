// Polygons as triangles, to be drawn.
#pragma once

#include <memory>
#include <span>

#include "render/math/vec.h"
#include "render/scene/mesh.h"

namespace penumbra {

// The inside of a simple polygon, convex or not, as a mesh whose front is where the vertices run
// counter-clockwise. Null: fewer than three vertices, or no area.
//
// Cost    O(n²) for most polygons
// Source  Meisters 1975, ear clipping
std::shared_ptr<const Mesh> MeshOfPolygon(std::span<const Vec3> vertices);

}  // namespace penumbra
