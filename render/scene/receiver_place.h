// Where receivers are.
//
//   auto patch = PlaceReceiver(receiver, instance_or_null);
#pragma once

#include <cstdint>
#include <memory>

#include "absl/status/statusor.h"
#include "render/math/vec.h"
#include "render/scene/receiver.h"
#include "render/scene/scene_limits.h"

namespace penumbra {

// The patch around a flat thing, and what of the patch it is.
struct PlacedPatch {
  Parallelogram patch;
  std::shared_ptr<const PlanarRegion> region;  // null: all of it
  double deviation_m = 0.0;                    // from the plane
};

// Around an instance all of whose vertices lie in one plane.
// Errors  kFailedPrecondition NOT_PLANAR, as for BoundingParallelogram
absl::StatusOr<PlacedPatch> PlaceOnInstance(const Instance& instance);

// Around one planar surface of an instance.
//
// Errors  kFailedPrecondition NOT_PLANAR: the triangle is none of the mesh's, or has no area, or
//         the surface is too thin
// Cost    that of PlanarSurfaces on a mesh's first use
absl::StatusOr<PlacedPatch> PlaceOnSurface(const Instance& instance, uint32_t triangle);

// Around a polygon that CheckPolygon finds right.
PlacedPatch PlaceOnPolygon(const PlanarPolygon& polygon);

// What is wrong with a polygon, with "vertices" as the start of the field path.
//
// Errors  kInvalidArgument LENGTH: fewer than 3; NON_FINITE; OUT_OF_BOUNDS; ZERO_AREA; NOT_PLANAR:
//         a vertex is further from the plane than 1e-4 of the extent; SELF_INTERSECTING;
//         kResourceExhausted QUOTA_POLYGON_VERTICES
// Cost    O(n²)
absl::Status CheckPolygon(const PlanarPolygon& polygon, const SceneLimits& limits);

// The receiver in the world, with the size of its grid. `instance` is the one that it lies on; null
// where there is none.
//
// Errors  kFailedPrecondition MISSING_INSTANCE, NOT_PLANAR
absl::StatusOr<ReceiverPatch> PlaceReceiver(const Receiver& receiver, const Instance* instance);

}  // namespace penumbra
