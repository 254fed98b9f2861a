// Draws triangles into a depth map.
//
//   DepthRaster raster(view, RasterFrame{view.frame});
//   raster.Draw(PlacedCaster(RasterFrame{view.frame}, instance));
//   DepthMap map = std::move(raster).Finish();
#pragma once

#include <array>
#include <memory>
#include <stop_token>
#include <vector>

#include "render/artifact/depth_map.h"
#include "render/light_view/clip_triangle.h"
#include "render/light_view/placed_caster.h"

namespace penumbra {

class DepthRaster {
 public:
  // `frame` is the view's, with any middle.
  DepthRaster(const LightView& view, const RasterFrame& frame);

  // `caster` is placed in the frame. Once stop is requested, which is asked for once a cluster,
  // nothing more is drawn.
  void Draw(const PlacedCaster& caster, const std::stop_token& stop = {});

  DepthMap Finish() &&;

 private:
  // A place in the frame as homogeneous pixels; see ClipCorner.
  DVec3 ImagePlaceOf(DVec3 q) const;
  // Whether nothing in the box can be seen.
  bool Misses(const FrameBox& box) const;
  RasterImage Image();
  // In double precision, what of the triangle is before the near plane.
  void DrawCarefully(const PlacedCaster& caster, size_t cluster, size_t triangle,
                     const RasterCut* cut);
  RasterPlanes PlanesThrough(const std::array<DVec3, 3>& places, const std::array<double, 3>& nears,
                             const std::array<Vec2, 3>& uvs) const;

  const LightView view_;
  const DVec2 scale_;   // pixels a slope, or a metre
  const DVec2 offset_;  // of the window, in pixels from straight ahead
  const DVec3 eye_;     // in the sheared frame
  const double near_depth_;
  RasterProjection projection_;
  std::unique_ptr<RasterVertices> vertices_;
  std::vector<float> nearest_;  // 0 from a point, −∞ from infinitely far: nothing
};

}  // namespace penumbra
