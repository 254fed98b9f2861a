// What a camera sees of a scene, and whether a point light sees it too, by Embree.
//
//   const EyeRays rays(scene);
//   const EyeView seen = rays.See(eye, position, arena);
//   std::vector<uint8_t> dark = rays.Shadow(seen, to_light, arena);
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "render/math/vec.h"
#include "render/scene/scene.h"
#include "tbb/task_arena.h"
#include "tests/support/volume_crossings.h"

struct RTCDeviceTy;
struct RTCSceneTy;

namespace penumbra::testing {

// One of each a pixel, in the order of EyeImage.
struct EyeView {
  std::vector<double> inverse_depths;  // 0: nothing is seen
  std::vector<Vec3> points;
  std::vector<Vec3> normals;  // of length 1, towards the eye
};

class EyeRays {
 public:
  // All instances without masks.
  explicit EyeRays(const Scene& scene);

  // Each pixel's ray begins at the near plane.
  EyeView See(const EyeImage& eye, tbb::task_arena& arena) const;

  // 1 where something is between the point and the light, or the surface faces away from it.
  //
  // light  a position (w = 1) or a direction towards it (w = 0)
  // offset  m, from the surface to where rays begin
  std::vector<uint8_t> Shadow(const EyeView& view, DVec4 light, float offset,
                              tbb::task_arena& arena) const;

 private:
  std::shared_ptr<RTCDeviceTy> device_;
  std::shared_ptr<RTCSceneTy> top_;
};

}  // namespace penumbra::testing
