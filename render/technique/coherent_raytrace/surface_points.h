// The points of surfaces at which shadows are computed.
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "absl/status/statusor.h"
#include "render/light_view/caster_bvh.h"
#include "render/scene/point_receiver.h"
#include "render/technique/coherent_raytrace/shadow_tracer.h"
#include "tbb/task_arena.h"

namespace penumbra {

// H×W points, row 0 first. A list is one row.
struct SurfacePoints {
  uint32_t width = 0;
  uint32_t height = 0;
  std::vector<SurfacePoint> points;
  std::vector<uint8_t> is_there;  // 1 where there is a surface
  // The points in the order in which they are visited, so that each is near the one before it;
  // empty: as they are.
  std::vector<uint32_t> order;

  size_t size() const { return points.size(); }
  size_t Visited(size_t place) const { return order.empty() ? place : order[place]; }
};

// As many, none of which is there.
SurfacePoints NoPoints(GridExtent grid);

// What follows takes what Check(PointReceiver) has found to be right.

// What the pixels' middles of the picture's part see; row 0 on top. Normals are those of the
// triangles, towards the eye.
//
// instances  all that the camera sees (CasterBvhs::Instances::kAll)
// Errors     kCancelled
// Cost       about 10 million pixels a second on two threads
absl::StatusOr<SurfacePoints> VisiblePoints(const CasterBvh& instances,
                                            const PicturePixels& picture, tbb::task_arena& arena,
                                            const std::stop_token& stop = {});

// A client's own points, their normals made of length 1. Visited as they come, or along a
// space-filling curve (Morton's) if neighbours are closer to each other there.
SurfacePoints ListedPoints(const GivenPoints& given);

// The texels of a lightmap on the uvs of the instance's mesh, which has some: those whose middle is
// in a triangle, of several in the first. Texel (i, j) is centred at uv ((i + ½)/W, (j + ½)/H),
// normals are those of the triangles' fronts.
//
// Errors  kCancelled
// Cost    O(texels of the triangles' bounding boxes), on one thread
absl::StatusOr<SurfacePoints> LightmapPoints(const Instance& instance,
                                             const LightmapTexels& lightmap,
                                             const std::stop_token& stop = {});

// How far neighbours are from each other, in m: the median over those in a row; 0 where there are
// none.
float SpacingOf(const SurfacePoints& points);

}  // namespace penumbra
