// For each pixel of a view, how near anything is that touches it.
//
//   const NearestDepths nearest(view, scene, arena);
//   if (nearest.In({x0, y0}, {x1, y1}) < nearness) …  // the rays through the window are free
#pragma once

#include <algorithm>
#include <cstdint>
#include <stop_token>
#include <vector>

#include "render/artifact/light_view.h"
#include "render/scene/scene.h"
#include "render/technique/coherent_raytrace/nearness.h"
#include "tbb/task_arena.h"

namespace penumbra {

// Not at pixels' centres but wherever a caster's triangle, its mask ignored, touches the pixel: no
// caster is nearer than what is said here, however small. A pyramid of the nearest of 2×2.
//
// Cost  40 ns · T for T triangles the size of a pixel, 2 ns a pixel, on one thread
class NearestDepths {
 public:
  // light  a box around the light as the eye sees it, in m along the frame's axes; from infinitely
  //        far of no use
  // stop   once it is requested nothing that is said holds
  NearestDepths(const LightView& view, const Scene& scene, const Window& light,
                tbb::task_arena& arena, const std::stop_token& stop = {});

  const LightView& view() const { return view_; }
  // The nearest anywhere in the picture, or, of what reaches beyond its edges, between any point in
  // the picture and the light.
  float All() const { return std::max(levels_.back().nearest[0], beside_); }
  // The nearest of the pixels that the window from `min` to `max`, in pixels, touches, and perhaps
  // of some around it; 0 for a window outside of the picture.
  float In(Vec2 min, Vec2 max) const;
  // Of pixel (x, y); 0 outside of the picture.
  float At(int x, int y) const;

 private:
  struct Level {
    int width, height;
    std::vector<float> nearest;
  };

  LightView view_;
  float beside_ = 0.0f;        // the nearest of what is beyond the picture's edges
  std::vector<Level> levels_;  // from the pixels to one node
};

}  // namespace penumbra
