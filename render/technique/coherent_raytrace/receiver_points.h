// The points that a spec asks for.
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "render/light_view/caster_bvh.h"
#include "render/scene/point_receiver.h"
#include "render/scene/scene.h"
#include "render/technique/coherent_raytrace/surface_points.h"
#include "tbb/task_arena.h"

namespace penumbra {

// Whether `scene` has what the receiver lies on.
//
// Errors  kNotFound UNKNOWN_ID, kFailedPrecondition MISSING_UV: a lightmap's instance
absl::Status CheckOn(const Scene& scene, const PointReceiver& receiver);

// `receiver` has passed both its checks.
//
// Errors  kCancelled; kResourceExhausted: the status of a CasterBvh
absl::StatusOr<SurfacePoints> PointsOf(const Scene& scene, const PointReceiver& receiver,
                                       CasterBvhs& bvhs, tbb::task_arena& arena,
                                       const std::stop_token& stop);

// The tiles' order: of a picture from where it is to begin, of other points as they come.
std::vector<uint32_t> TileOrder(const PointReceiver& receiver, std::span<const PixelRect> tiles);

}  // namespace penumbra
