// The shadow that a volume draws into a picture, compared with shadow rays and with the map.
//
//   const MaskComparison c = CompareMasks(rays, mesh, eye, arena);
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/artifact/shadow_volume_mesh.h"
#include "tests/support/eye_rays.h"

namespace penumbra::testing {

struct MaskComparison {
  size_t pixels = 0;       // all, those that show nothing included
  size_t not_as_rays = 0;  // where the mask and a shadow ray disagree
  size_t astray = 0;  // of those, further than two map texels from a boundary of the rays' shadow,
                      // as the picture shows it or as it is on the surface's plane
  size_t not_as_map = 0;          // where the mask and a look into the map disagree
  size_t not_as_nearest = 0;      // the same of the nearest sample alone
  size_t largest_unlike_map = 0;  // of the parts where both disagree with the mask
  size_t largest_astray = 0;      // pixels of the largest connected part of those astray
  size_t map_not_as_rays = 0;     // where the look into the map and a shadow ray disagree

  void Add(const MaskComparison& other);
};

struct MaskCase {
  const EyeRays& rays;
  const ShadowVolumeMesh& mesh;
  const EyeImage& eye;
  DVec4 light;           // a position, or a direction with w = 0
  float offset = 1e-4f;  // m, where shadow rays begin over surfaces
  // The mesh's own mask, if something else drew it; empty: MaskOf().
  std::vector<uint8_t> drawn{};
};

// What faces away from the light is in shadow in all three masks.
//
// Whether each pixel is in shadow by the mesh: caps included.
std::vector<uint8_t> MaskOf(const ShadowVolumeMesh& mesh, const EyeImage& eye, const EyeView& view);

MaskComparison CompareMasks(const MaskCase& c, tbb::task_arena& arena);

// Of the pixels that are set, the size of the largest part that hangs together by sides.
size_t LargestPart(const std::vector<uint8_t>& set, uint32_t width);

}  // namespace penumbra::testing
