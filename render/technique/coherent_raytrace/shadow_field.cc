#include "render/technique/coherent_raytrace/shadow_field.h"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <numeric>

#include "absl/strings/str_cat.h"
#include "render/math/parallel_for.h"
#include "render/scene/field_error.h"
#include "render/scene/unoccluded_light.h"
#include "render/technique/coherent_raytrace/light_proof.h"

namespace penumbra {
namespace {

constexpr uint32_t kTileSide = 32;
constexpr uint32_t kTilePoints = kTileSide * kTileSide;  // of a list

// How many times as far as its neighbours usually are a point may be for a prediction.
constexpr float kSpacings = 4.0f;

class FieldWork {
 public:
  FieldWork(const AreaLight& light, const SurfacePoints& points, const ShadowTracer& tracer,
            const ShadowFieldSettings& settings, const std::stop_token& stop)
      : light_(light),
        square_(light),
        points_(points),
        tracer_(tracer),
        settings_(settings),
        stop_(stop),
        tiles_(TilesOf(points.width, points.height)) {
    sampling_ = settings.sampling;
    if (square_.is_single()) sampling_.side = 1;
    sampling_.prediction_distance = PredictionDistance(settings, points);
    field_.sample_count = sampling_.side * sampling_.side;
    field_.prediction_distance = sampling_.prediction_distance;
    field_.visible.resize(points.size());
    if (settings.shades) field_.irradiance.resize(points.size());
    if (settings.tile_order) {
      order_ = settings.tile_order(tiles_);
    } else {
      order_.resize(tiles_.size());
      std::iota(order_.begin(), order_.end(), 0u);
    }
  }

  // On as many threads as ask.
  void Run() {
    CoherentSampler sampler(square_, tracer_, sampling_);
    for (;;) {
      const size_t next = next_.fetch_add(1, std::memory_order_relaxed);
      if (next >= order_.size()) break;
      Compute(tiles_[order_[next]], sampler);
      if (stop_.stop_requested()) break;
    }
  }

  ShadowField Finish() && { return std::move(field_); }

 private:
  void Compute(const PixelRect& tile, CoherentSampler& sampler);
  float Shade(const SurfacePoint& point, const CellMask& visible) const;
  void Report(const PixelRect& tile, const TraceCounts& counts, uint64_t there, uint64_t free);

  const AreaLight& light_;
  const LightSquare square_;
  const SurfacePoints& points_;
  const ShadowTracer& tracer_;
  const ShadowFieldSettings& settings_;
  const std::stop_token& stop_;
  SamplingSettings sampling_;
  const std::vector<PixelRect> tiles_;
  std::vector<uint32_t> order_;
  std::atomic<size_t> next_ = 0;
  std::mutex mutex_;  // of what follows
  ShadowField field_;
  size_t tiles_done_ = 0;
};

void FieldWork::Compute(const PixelRect& tile, CoherentSampler& sampler) {
  sampler.Restart();
  uint64_t there = 0, free = 0;
  const KnownCells nothing{CellMask(sampling_.side), CellMask(sampling_.side)};
  for (uint32_t row = 0; row < tile.height; ++row) {
    if (stop_.stop_requested()) return;
    for (uint32_t column = 0; column < tile.width; ++column) {
      // To and fro, so that each point is next to the one before.
      const uint32_t x = tile.x + (row % 2 == 0 ? column : tile.width - 1 - column);
      const size_t i = size_t{tile.y + row} * points_.width + x;
      if (!points_.is_there[i]) continue;
      ++there;
      const SurfacePoint& point = points_.points[i];
      const uint64_t before = sampler.counts().rays;
      const CellMask visible = sampler.Visible(
          point, i, settings_.proof ? settings_.proof->Of(point, sampling_.side) : nothing);
      free += sampler.counts().rays == before;
      field_.visible[i] = static_cast<uint16_t>(visible.Count());
      if (settings_.shades) field_.irradiance[i] = Shade(point, visible);
    }
  }
  Report(tile, sampler.TakeCounts(), there, free);
}

float FieldWork::Shade(const SurfacePoint& point, const CellMask& visible) const {
  if (visible.empty()) return 0.0f;
  const double unoccluded = UnoccludedFactor(light_, DVec3(point.position), DVec3(point.normal));
  const uint32_t side = sampling_.side;
  if (visible == CellMask::All(side)) return static_cast<float>(unoccluded);
  const LightSquare::Seen seen = square_.From(point.position);
  double seen_sum = 0, sum = 0;
  CellMask::All(side).ForEach([&](uint32_t cell) {
    const Vec2 at(cell % CellMask::kMaxSide, cell / CellMask::kMaxSide);
    const Vec2 middle = (at + 0.5f) / static_cast<float>(side);
    const double k = seen.WeightAt(middle, point.normal);
    sum += k;
    if (visible.Has(cell)) seen_sum += k;
  });
  return sum > 0 ? static_cast<float>(unoccluded * (seen_sum / sum)) : 0.0f;
}

void FieldWork::Report(const PixelRect& tile, const TraceCounts& counts, uint64_t there,
                       uint64_t free) {
  const std::lock_guard lock(mutex_);
  field_.counts += counts;
  field_.points += there;
  field_.free_points += free;
  ++tiles_done_;
  if (!settings_.on_tile) return;
  settings_.on_tile(
      {.tile = tile, .tiles_done = tiles_done_, .tiles = tiles_.size(), .rays = field_.counts.rays},
      field_);
}

}  // namespace

float PredictionDistance(const ShadowFieldSettings& settings, const SurfacePoints& points) {
  return settings.prediction_distance.value_or(kSpacings * SpacingOf(points));
}

std::vector<PixelRect> TilesOf(uint32_t width, uint32_t height) {
  const uint32_t tile_width = height == 1 ? kTilePoints : kTileSide;
  std::vector<PixelRect> tiles;
  for (uint32_t y = 0; y < height; y += kTileSide) {
    for (uint32_t x = 0; x < width; x += tile_width) {
      tiles.push_back({.x = x,
                       .y = y,
                       .width = std::min(tile_width, width - x),
                       .height = std::min(kTileSide, height - y)});
    }
  }
  return tiles;
}

absl::StatusOr<ShadowField> ComputeShadowField(const AreaLight& light, const SurfacePoints& points,
                                               const ShadowTracer& tracer,
                                               const ShadowFieldSettings& settings,
                                               tbb::task_arena& arena,
                                               const std::stop_token& stop) {
  const uint32_t side = settings.sampling.side;
  if (side < 1 || side > CellMask::kMaxSide) {
    return FieldError(absl::StatusCode::kInvalidArgument, "RANGE", "samples.side",
                      absl::StrCat("found ", side, ", need 1 to ", CellMask::kMaxSide));
  }
  FieldWork work(light, points, tracer, settings, stop);
  RunIn(arena, [&] { ParallelFor(arena.max_concurrency(), [&](int) { work.Run(); }); });
  if (stop.stop_requested()) return absl::CancelledError("stopped");
  return std::move(work).Finish();
}

}  // namespace penumbra
