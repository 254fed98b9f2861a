#include "render/technique/coherent_raytrace/receiver_points.h"

#include <algorithm>
#include <numeric>
#include <variant>

#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

constexpr char kInstance[] = "points.lightmap.instance_id";

double SquaredDistance(const PixelRect& tile, DVec2 from) {
  const DVec2 middle(tile.x + 0.5 * tile.width, tile.y + 0.5 * tile.height);
  return glm::dot(middle - from, middle - from);
}

struct Finder {
  const Scene& scene;
  CasterBvhs& bvhs;
  tbb::task_arena& arena;
  const std::stop_token& stop;

  absl::StatusOr<SurfacePoints> operator()(const PicturePixels& picture) const {
    const auto all = bvhs.Of(scene, CasterBvhs::Instances::kAll);
    if (!all->status().ok()) return all->status();
    return VisiblePoints(*all, picture, arena, stop);
  }
  absl::StatusOr<SurfacePoints> operator()(const LightmapTexels& lightmap) const {
    return LightmapPoints(*scene.FindInstance(lightmap.instance_id), lightmap, stop);
  }
  absl::StatusOr<SurfacePoints> operator()(const GivenPoints& given) const {
    return ListedPoints(given);
  }
};

}  // namespace

absl::Status CheckOn(const Scene& scene, const PointReceiver& receiver) {
  const auto* lightmap = std::get_if<LightmapTexels>(&receiver);
  if (lightmap == nullptr) return absl::OkStatus();
  const auto instance = scene.FindInstance(lightmap->instance_id);
  if (!instance) {
    return FieldError(
        absl::StatusCode::kNotFound, "UNKNOWN_ID", kInstance,
        absl::StrCat("found ", lightmap->instance_id, ", need an instance of the scene"));
  }
  if (!instance->mesh->uvs().empty()) return absl::OkStatus();
  return FieldError(
      absl::StatusCode::kFailedPrecondition, "MISSING_UV", kInstance,
      absl::StrCat("found ", lightmap->instance_id, ", whose mesh has no uvs; need one that has"));
}

absl::StatusOr<SurfacePoints> PointsOf(const Scene& scene, const PointReceiver& receiver,
                                       CasterBvhs& bvhs, tbb::task_arena& arena,
                                       const std::stop_token& stop) {
  return std::visit(Finder{scene, bvhs, arena, stop}, receiver);
}

std::vector<uint32_t> TileOrder(const PointReceiver& receiver, std::span<const PixelRect> tiles) {
  std::vector<uint32_t> order(tiles.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto* picture = std::get_if<PicturePixels>(&receiver);
  if (picture == nullptr) return order;
  const PixelRect part = picture->part();
  const PixelRect first = picture->first.empty() ? part : picture->first;
  const DVec2 middle(first.x - part.x + 0.5 * first.width, first.y - part.y + 0.5 * first.height);
  std::ranges::stable_sort(order, {},
                           [&](uint32_t i) { return SquaredDistance(tiles[i], middle); });
  return order;
}

}  // namespace penumbra
