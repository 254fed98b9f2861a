// What a light shines on and that casts no shadow: techniques want to see it all the same.
//
//   for (const auto& surface : SurfacesWithoutShadows(scene)) …
#pragma once

#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "render/scene/scene.h"

namespace penumbra {

// For each instance of `scene` that receives and does not cast, and for each receiver that stands
// by itself, as a whole patch, a scene of its own: alone, since it hides none of the others. There
// it casts, so that depth maps show it.
std::vector<std::shared_ptr<const Scene>> SurfacesWithoutShadows(const Scene& scene);

// `scene` with an instance for each receiver that stands by itself; its own are the same objects,
// and so is the table of them where there is no such receiver.
//
// Errors  kResourceExhausted: the scene has as many instances as it may already
absl::StatusOr<std::shared_ptr<const Scene>> WithAllSurfaces(const Scene& scene);

}  // namespace penumbra
