// The planar surfaces of a mesh: triangles joined by their edges that lie in one plane.
//
//   const PlanarSurfaces& surfaces = mesh.planar_surfaces();
//   for (size_t s = 0; s < surfaces.count(); ++s) … surfaces.Triangles(s)
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "render/math/vec.h"

namespace penumbra {

// A surface grows from its largest triangle over shared edges (of vertices at one place, whatever
// their index) to triangles all of whose corners lie within 2e-5 of the mesh's extent of the first
// one's plane and that face the same way within 2.5°. Slivers thinner than that distance may face
// anywhere. So a surface is flat however many triangles it has, and a curved one falls into pieces.
// An edge at which more than 64 triangles meet joins nothing.
//
// Every triangle with an area belongs to one surface; one without joins a surface that it touches,
// or none. An affine map of the mesh keeps all this but the distances.
class PlanarSurfaces {
 public:
  // Shapes  V positions, 3T indices < V
  // Cost    O(T log T), some 60 bytes a triangle while it runs and 8 after
  PlanarSurfaces(std::span<const Vec3> positions, std::span<const uint32_t> indices);

  size_t count() const { return begins_.size() - 1; }
  // In ascending order; those of the surface with the largest first triangle come first.
  std::span<const uint32_t> Triangles(size_t surface) const {
    return std::span(triangles_).subspan(begins_[surface], begins_[surface + 1] - begins_[surface]);
  }
  // None: there is no such triangle, or it has no area and is by itself.
  std::optional<size_t> SurfaceOf(uint32_t triangle) const;

 private:
  std::vector<uint32_t> triangles_;
  std::vector<uint32_t> begins_;      // into triangles_, and its end
  std::vector<uint32_t> surface_of_;  // T
};

}  // namespace penumbra
