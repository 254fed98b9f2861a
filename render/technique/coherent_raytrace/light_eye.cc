#include "render/technique/coherent_raytrace/light_eye.h"

#include <algorithm>
#include <span>

#include "render/light_view/light_face.h"
#include "render/light_view/view_fit.h"
#include "render/technique/coherent_raytrace/light_square.h"

namespace penumbra {
namespace {

constexpr Window kAnywhere{.min = DVec2(-1e9), .max = DVec2(1e9)};

// Nothing that casts is beyond the view's edges.
bool CoversAll(const LightView& view, std::span<const Aabb> boxes) {
  if (view.from_infinity) return true;
  return std::ranges::all_of(boxes, [&](const Aabb& box) {
    const Window seen = WindowOf(view.frame, view.eye, 0.0, box, kAnywhere);
    const DVec2 slack = 1e-9 * view.window.size();
    return seen.empty() || (glm::all(glm::greaterThanEqual(seen.min, view.window.min - slack)) &&
                            glm::all(glm::lessThanEqual(seen.max, view.window.max + slack)));
  });
}

}  // namespace

std::vector<EyeView> ViewsFrom(const AreaLight& light, const Scene& scene, Vec3 place,
                               uint32_t pixels) {
  const std::vector<Aabb>& boxes = scene.casters().bounds();
  const bool at_infinity = LightSquare(light).is_at_infinity();
  std::vector<EyeView> views;
  for (const LightFace& face : FacesOf(light, scene.Bounds())) {
    const LightSample sample{.point = place, .at_infinity = at_infinity};
    const DVec2 whole = face.window.size();
    const auto tight = ViewFrom(face, sample, boxes, 1e-6 * std::max(whole.x, whole.y));
    if (!tight) continue;
    const DVec2 size = tight->window.size();
    const auto view = ViewFrom(face, sample, boxes, std::max(size.x, size.y) / pixels);
    if (view) views.push_back({*view, CoversAll(*view, boxes)});
  }
  return views;
}

std::vector<Vec3> LightVertices(const AreaLight& light) {
  const LightSquare square(light);
  if (square.kind() == LightSquare::Kind::kSphere) {
    const auto& [center, radius, radiance] = std::get<SphereLight>(light.shape);
    std::vector<Vec3> vertices;
    for (const Vec3 axis : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}) {
      vertices.push_back(center + radius * axis);
      vertices.push_back(center - radius * axis);
    }
    return vertices;
  }
  const LightSquare::Seen seen = square.From(Vec3(0.0f));
  if (square.is_single()) return {seen.TargetAt(Vec2(0.5f))};
  std::vector<Vec3> vertices;
  for (const Vec2 corner : {Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)}) {
    vertices.push_back(seen.TargetAt(corner));
  }
  return vertices;
}

}  // namespace penumbra
