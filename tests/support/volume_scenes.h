// Four scenes like those that McCool's shadow volumes were measured with, and random poses of them.
//
//   for (const VolumeScene& scene : VolumeScenes()) … Pose::Random(i) …
//
// Source  McCool 2000, §9, figure 11, of which the sizes are known: what stands on a square of
//         ground also hangs below it, mirrored, so that all views show as much
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "render/scene/scene.h"
#include "tests/support/volume_crossings.h"

namespace penumbra::testing {

struct VolumeScene {
  const char* name;
  std::shared_ptr<const Scene> scene;
  size_t triangles;
};

// a  a ring and a ball (3,842 triangles for the paper's 3,756)
// b  towers (3,122 for 3,132)
// c  balls on balls on a ball (448,450 for 450,132)
// d  a pot with a handle (7,202 for 7,332)
//
// and a harder one, a tree whose twigs and leaves are about as wide as a sample.
std::vector<VolumeScene> VolumeScenes();

// From where a scene of about 1.5 m around the origin is seen and lit: eye and light are 55 degrees
// apart, and turned together.
struct Pose {
  DVec3 eye, light, up;

  static Pose Random(uint64_t seed);
  // Down to 1 % of its distance.
  EyeImage Image(uint32_t side) const;
};

}  // namespace penumbra::testing
