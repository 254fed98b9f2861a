// What a light shines on and that casts no shadow: techniques want to see it all the same.
//
//   for (const auto& surface : SurfacesWithoutShadows(scene)) …
#pragma once

#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "render/scene/scene.h"

namespace penumbra {

// An instance for each of `scene` that receives and does not cast, under its own id, and for each
// receiver that stands by itself, as a whole patch, under an id that no instance of the scene has.
// All cast, so that depth maps and rays see them.
std::vector<Instance> InstancesWithoutShadows(const Scene& scene);

// Each of them in a scene of its own: alone, since it hides none of the others.
std::vector<std::shared_ptr<const Scene>> SurfacesWithoutShadows(const Scene& scene);

// `scene` with all of them among its instances, which casts what it cast and what it showed shadows
// on. Instances that cast are the same objects.
//
// Errors  kResourceExhausted: the scene has as many as it may already
absl::StatusOr<std::shared_ptr<const Scene>> WithAllSurfaces(const Scene& scene);

}  // namespace penumbra
