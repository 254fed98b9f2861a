// Where the faces of a run of edges lie, and how they are turned.
#pragma once

#include "render/math/vec.h"
#include "render/scene/silhouette_edges.h"

namespace penumbra {

// What bounds a run of faces, before it is rounded.
struct FaceBound {
  DVec3 center{0.0};
  double radius = -1;  // none: nothing in it
  DVec3 axis{0, 0, 1};
  double spread = 0;  // radians between the axis and the normals at most
};

// A ball around two balls and a cone around two cones.
FaceBound Around(const FaceBound& a, const FaceBound& b);

// Appends `bound`, widened by what rounding may do.
void Push(const FaceBound& bound, ClusterLevel& level);

}  // namespace penumbra
