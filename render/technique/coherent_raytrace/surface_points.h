// The points of surfaces at which shadows are computed.
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "absl/status/statusor.h"
#include "render/light_view/caster_bvh.h"
#include "render/scene/camera.h"
#include "render/technique/coherent_raytrace/shadow_tracer.h"
#include "tbb/task_arena.h"

namespace penumbra {

// H×W points, row 0 first. A list is one row.
struct SurfacePoints {
  uint32_t width = 0;
  uint32_t height = 0;
  std::vector<SurfacePoint> points;
  std::vector<uint8_t> is_there;  // 1 where there is a surface

  size_t size() const { return points.size(); }
};

// Errors  kInvalidArgument, RANGE: "width", "height": not 1 to 16384
absl::Status CheckPictureSize(uint32_t width, uint32_t height);

// What the pixels' middles of a picture of `width` × `height` see, in the part `crop` of it; row 0
// on top. Normals are those of the triangles, towards the eye.
//
// instances  all that the camera sees (CasterBvhs::Instances::kAll)
// Errors     those of CheckCamera; kInvalidArgument, RANGE: "width", "height", "crop"; kCancelled
// Cost       about 10 million pixels a second on two threads
absl::StatusOr<SurfacePoints> VisiblePoints(const CasterBvh& instances, const Camera& camera,
                                            uint32_t width, uint32_t height, const PixelRect& crop,
                                            tbb::task_arena& arena,
                                            const std::stop_token& stop = {});

// A client's own points, their normals made of length 1.
//
// Errors  kInvalidArgument, NON_FINITE or ZERO_LENGTH: "points[3].position", "points[3].normal"
absl::StatusOr<SurfacePoints> ListedPoints(std::span<const SurfacePoint> points);

// The texels of a lightmap of `width` × `height` on the mesh's uv set: those whose middle is in a
// triangle, of several in the first. Texel (i, j) is centred at uv ((i + ½)/W, (j + ½)/H), normals
// are those of the triangles' fronts.
//
// Errors  kInvalidArgument: RANGE "width", "height"; kFailedPrecondition, MISSING_UV: "instance"
absl::StatusOr<SurfacePoints> LightmapPoints(const Instance& instance, uint32_t width,
                                             uint32_t height);

// How far neighbours are from each other, in m: the median over those in a row; 0 where there are
// none.
float SpacingOf(const SurfacePoints& points);

}  // namespace penumbra
