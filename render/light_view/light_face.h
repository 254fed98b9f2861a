// The directions in which a light looks at a scene.
//
//   for (const LightFace& face : FacesOf(*light, scene->Bounds())) {
//     … a view from each light sample, all with their image planes parallel to the face's …
//   }
#pragma once

#include <vector>

#include "render/artifact/light_view.h"
#include "render/math/aabb.h"
#include "render/scene/area_light.h"

namespace penumbra {

// One direction to look in, and what is to be seen there from the light's centre.
struct LightFace {
  LightFrame frame;
  bool from_infinity = false;
  Window window;
};

// The widest slope that one view takes in: 63 degrees to either side. Beyond it pixels in the
// middle would be less than half as dense as with several views.
inline constexpr double kMaxSlope = 2.0;

// The faces that together see all of `bounds` from the centre of `light`; none for empty bounds.
//
// A spot is one view along its axis, as wide as its cone. A rectangle or disk looks along its
// normal, and where the scene spreads further than kMaxSlope also along its edges; one that shines
// from both faces looks both ways. Points and spheres look along the world's axes. A distant light
// is one view. Faces that see nothing of `bounds` are left out, the others cut to it.
std::vector<LightFace> FacesOf(const AreaLight& light, const Aabb& bounds);

// Bit 0 of `corner`, 0 … 7, chooses between min.x and max.x, bit 1 in y, bit 2 in z.
DVec3 CornerOf(const Aabb& box, int corner);

// What part of the image plane of `frame` a box fills as seen from `eye`, a point in the frame, in
// front of it by more than `near` metres. Cut to `limit`; min > max where nothing is left.
Window WindowOf(const LightFrame& frame, DVec3 eye, double near, const Aabb& box,
                const Window& limit);

// What part of the image plane a box fills as seen from infinitely far: x and y move by `slope` for
// each metre of depth. In metres.
Window ShearedWindow(const LightFrame& frame, DVec2 slope, const Aabb& box);

}  // namespace penumbra
