#include "client/display/suggest_ambient.h"

#include "render/scene/unoccluded_light.h"

namespace penumbra {

Vec3 SuggestAmbient(const Scene& scene) {
  // Dark enough to leave shadows their shape, bright enough to see in.
  constexpr float kShare = 0.06f;
  const Aabb bounds = scene.Bounds();
  if (scene.lights().empty()) return Vec3(1);
  const Vec3 center = bounds.empty() ? Vec3(0) : bounds.center();
  Vec3 sum(0);
  for (const auto& [id, light] : scene.lights()) {
    Vec3 brightest(0);
    for (const Vec3 n : {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 1, 0), Vec3(0, -1, 0),
                         Vec3(0, 0, 1), Vec3(0, 0, -1)}) {
      brightest = glm::max(brightest, UnoccludedRadiance(*light, center, n));
    }
    sum += brightest;
  }
  return kShare * sum;
}

}  // namespace penumbra
