// What closes a shadow's boundary where an eye's near plane cuts it.
//
//   const VolumeCapper capper(volume, mesh.bias_px, mesh.light);   // kept
//   const VolumeCaps caps = capper.CapsFor(clip_from_world, near);  // each frame
//   if (caps.inverts) … every pixel begins in shadow …
//   … draw caps.corners, three a triangle, without a depth test: each toggles its pixels …
#pragma once

#include <vector>

#include "render/artifact/shadow_volume_mesh.h"

namespace penumbra {

struct VolumeCaps {
  bool inverts =
      false;  // all of the near plane that the eye sees is in the volume; no corners then
  // Clip space, on the near plane; w ≥ 0. Of kObject each triangle adds one surface, and they
  // overlap; of others they do not.
  std::vector<Vec4> corners;
  size_t tested_samples = 0;

  size_t triangle_count() const { return corners.size() / 3; }
};

// A place on the near plane is in shadow if the surface is before it, as the light sees it. Each
// sample is on the light's side of the plane or beyond it: where all are beyond there is no cap,
// where all are before it the whole plane is inverted, and between the part of each cell's
// triangles that is before it is projected onto the plane, in homogeneous coordinates. Runs of
// cells that are wholly before it make one rectangle. The caps are those of the samples' surface
// also where the mesh is vectorized: walls may be a sample off.
//
// Source  McCool 2000, §6.2; departs: the light may be on either side of the near plane, and what
//         is before the plane is a matter of the light's side, not the eye's
class VolumeCapper {
 public:
  // Refers to `volume`.
  VolumeCapper(const ShadowVolume& volume, float bias_px, const AreaLight& light);

  // clip_from_world  a perspective: w is the depth along the view, in metres
  // near             the depth of what is cut off, > 0
  // Cost             O(samples that the near plane's rectangle hides from the light), 10 ns each
  VolumeCaps CapsFor(const DMat4& clip_from_world, double near) const;

 private:
  const ShadowVolume& volume_;
  DVec4 light_;  // homogeneous: a position, or the direction towards it
  std::vector<VolumeGrid> grids_;
  std::vector<double> nearest_;  // the greatest finite nearness of each, or what stands for it
};

}  // namespace penumbra
