#include "tests/support/straight_edge.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "render/scene/light_sample.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

constexpr int kPlaces = 5000;
constexpr double kStep = 0.001;
constexpr double kReach = 0.5 * kPlaces * kStep;
constexpr float kSheetSide = 8.0f;

Vec3 Across(const StraightEdge& edge) {
  return Vec3(static_cast<float>(std::cos(edge.angle)), 0,
              static_cast<float>(std::sin(edge.angle)));
}

Vec3 PlaceAt(const StraightEdge& edge, int i) {
  return static_cast<float>((i + 0.5) * kStep - kReach) * Across(edge);
}

}  // namespace

std::shared_ptr<const Scene> StraightEdge::MakeScene() const {
  const Vec3 out = Across(*this), along(-out.z, 0, out.x), up(0, 1, 0);
  const auto square = MeshOf(UnitSquareGeometry());
  const Instance sheet{
      .id = "sheet",
      .mesh = square,
      .world_from_mesh = Affine(0.5f * kSheetSide * out, up, kSheetSide * along,
                                static_cast<float>(height) * up - 0.5f * kSheetSide * out)};
  const Instance floor{
      .id = "floor", .mesh = square, .world_from_mesh = Placed(Vec3(0), Vec3(5, 1, 5))};
  return Scene::Empty("edge")
      ->Apply({.upsert_instances = {sheet, floor}, .upsert_lights = {light}})
      .value();
}

std::optional<double> PenumbraWidth(const StraightEdge& edge, const Artifact& artifact) {
  std::optional<int> first, last;
  for (int i = 0; i < kPlaces; ++i) {
    const float share = Visibility(artifact, PlaceAt(edge, i), Vec3(0, 1, 0));
    if (!first && share >= 0.1f) first = i;
    if (!last && share >= 0.9f) last = i;
  }
  if (!first || !last || *first == 0) return std::nullopt;
  return (*last - *first) * kStep;
}

double TruePenumbraWidth(const StraightEdge& edge) {
  const DVec3 out(Across(edge));
  std::vector<double> appears;  // of equal shares
  for (uint64_t seed = 0; seed < 4; ++seed) {
    for (const LightSample& sample : SampleLight(edge.light, 1024, seed, Vec3(0))) {
      const DVec3 from(sample.point);
      const double along = glm::dot(from, out);
      appears.push_back(sample.at_infinity ? -edge.height * along / from.y
                                           : -edge.height * along / (from.y - edge.height));
    }
  }
  std::ranges::sort(appears);
  const auto at = [&](double share) {
    return appears[static_cast<size_t>(share * appears.size())];
  };
  return at(0.9) - at(0.1);
}

}  // namespace penumbra::testing
