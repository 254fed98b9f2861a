// What a light shines on and that casts no shadow: layers of it are wanted all the same.
//
//   for (const auto& surface : SurfacesWithoutShadows(scene)) …
#pragma once

#include <memory>
#include <vector>

#include "render/scene/scene.h"

namespace penumbra {

// A scene of its own for each instance of `scene` that receives and does not cast, and for each
// receiver that stands by itself, as a whole patch. There it casts, so that depth maps show it;
// alone, since it hides none of the others.
std::vector<std::shared_ptr<const Scene>> SurfacesWithoutShadows(const Scene& scene);

}  // namespace penumbra
