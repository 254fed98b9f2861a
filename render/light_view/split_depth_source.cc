#include "render/light_view/split_depth_source.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/light_view/view_fit.h"

namespace penumbra {
namespace {

bool IsSimple(const Instance& instance) {
  return instance.mesh->triangle_count() <= SplitDepthSource::kFewTriangles &&
         instance.alpha_mask == nullptr;
}

std::shared_ptr<const Scene> SimpleCasters(const Scene& scene) {
  SceneDelta delta;
  for (const auto& [id, instance] : scene.instances()) {
    if (instance->casts && IsSimple(*instance)) delta.upsert_instances.push_back(*instance);
  }
  auto simple = Scene::Empty(scene.id());
  const auto all = simple->Apply(std::move(delta));
  return all.ok() ? *all : simple;
}

// A part of a view's own pixels (PartOf).
void Paste(const DepthMap& part, DepthMap& map) {
  const DVec2 offset = (part.view.window.min - map.view.window.min) * map.view.pixels_per_slope();
  const DVec2 first = glm::round(offset);
  for (uint32_t y = 0; y < part.view.height; ++y) {
    const auto row = part.depths.begin() + size_t{y} * part.view.width;
    const size_t to = (static_cast<size_t>(first.y) + y) * map.view.width;
    std::copy(row, row + part.view.width, map.depths.begin() + to + static_cast<size_t>(first.x));
  }
}

}  // namespace

SplitDepthSource::SplitDepthSource(const Scene& scene, CasterBvhs& bvhs, tbb::task_arena& arena)
    : scene_(scene),
      bvhs_(bvhs),
      arena_(arena),
      simple_(SimpleCasters(scene)),
      sizes_(scene),
      simple_sizes_(*simple_),
      raster_(*simple_, arena) {
  for (const auto& [id, instance] : scene.instances()) {
    if (!instance->casts || simple_->instances().contains(id)) continue;
    if (instance->mesh->triangle_count() > 0) others_.Add(WorldBounds(*instance));
  }
}

double SplitDepthSource::CostNs(const LightView& view) const {
  const double drawn = RasterNs(simple_sizes_.WorkOf(view));
  const auto part = PartOf(view, others_);
  return part ? drawn + RaysNs(sizes_.WorkOf(*part)) : drawn;
}

absl::StatusOr<std::vector<DepthMap>> SplitDepthSource::DrawTogether(
    std::span<const LightView> views, const std::stop_token& stop) {
  std::vector<DepthMap> maps;
  absl::Status status = raster_.Draw(views, stop, [&](size_t, DepthMap map) {
    maps.push_back(std::move(map));
    return absl::OkStatus();
  });
  if (!status.ok()) return status;
  std::vector<LightView> parts;
  std::vector<size_t> of;
  for (size_t i = 0; i < views.size(); ++i) {
    const auto part = PartOf(views[i], others_);
    if (!part) continue;
    parts.push_back(*part);
    of.push_back(i);
  }
  if (parts.empty()) return maps;
  if (!rays_) rays_.emplace(bvhs_.Of(scene_), arena_);
  status = rays_->Draw(parts, stop, [&](size_t k, DepthMap map) {
    Paste(map, maps[of[k]]);
    return absl::OkStatus();
  });
  if (!status.ok()) return status;
  return maps;
}

absl::Status SplitDepthSource::Draw(std::span<const LightView> views, const std::stop_token& stop,
                                    const Take& take) {
  if (absl::Status status = CheckViews(views); !status.ok()) return status;
  for (size_t first = 0; first < views.size();) {
    auto maps = DrawTogether(views.subspan(first, ViewsAtOnce(views.subspan(first))), stop);
    if (!maps.ok()) return maps.status();
    for (DepthMap& map : *maps) {
      if (stop.stop_requested()) return absl::CancelledError("stopped");
      if (absl::Status status = take(first++, std::move(map)); !status.ok()) return status;
    }
  }
  return absl::OkStatus();
}

std::string SplitDepthSource::drawn_by() const {
  if (!rays_) return raster_.drawn_by();
  if (simple_->instances().empty()) return rays_->drawn_by();
  return absl::StrCat(raster_.drawn_by(), " and ", rays_->drawn_by());
}

}  // namespace penumbra
