#include "render/technique/coherent_raytrace/shadow_field.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <mutex>
#include <numeric>
#include <optional>

#include "absl/strings/str_cat.h"
#include "render/math/parallel_for.h"
#include "render/scene/field_error.h"
#include "render/scene/unoccluded_light.h"
#include "render/technique/coherent_raytrace/light_proof.h"
#include "render/technique/coherent_raytrace/sampler_front.h"

namespace penumbra {
namespace {

constexpr uint32_t kTileSide = SamplerFront::kLanes;

// Points of a list's tile: long rows, of which only the first points have none before, but some
// tiles for each thread.
constexpr uint32_t kLeastTilePoints = 32 * kTileSide, kMostTilePoints = 128 * kTileSide;
constexpr uint32_t kListTiles = 64;

// How many times as far as its neighbours usually are a point may be for a prediction. And the
// shadow of something half-way up to the light, which moves by as much as the points do, must not
// go over more than a part of the light: nothing at its edge would tell of what is in its middle.
constexpr float kSpacings = 4.0f;
constexpr float kLightWidths = 0.25f;

float PredictionDistanceAt(float spacing, const LightSquare& square,
                           const ShadowFieldSettings& settings) {
  const float distance = kSpacings * spacing;
  return settings.prediction_distance.value_or(
      square.is_at_infinity() ? distance : std::min(distance, kLightWidths * square.width()));
}

// One sample is enough of a light without extent.
SamplingSettings SamplingFor(const LightSquare& square, const ShadowFieldSettings& settings) {
  SamplingSettings sampling = settings.sampling;
  if (square.is_single()) sampling.side = 1;
  return sampling;
}

// Rows of neighbouring points, one for each lane of a front: those of a picture's tile, or parts of
// a list's one after another.
struct TileRows {
  TileRows(const PixelRect& tile, const SurfacePoints& points)
      : first(size_t{tile.y} * points.width + tile.x) {
    const bool is_list = points.height == 1;
    lag = is_list ? 0 : 1;
    length = is_list ? (tile.width + SamplerFront::kLanes - 1) / SamplerFront::kLanes : tile.width;
    stride = is_list ? length : points.width;
    count = is_list ? (tile.width + length - 1) / length : tile.height;
    end = size_t{tile.y + tile.height - 1} * points.width + tile.x + tile.width;
  }

  // The place of a row's point in the points, if it has one there.
  std::optional<size_t> At(uint32_t row, uint32_t column, const SurfacePoints& points) const {
    const size_t place = first + row * stride + column;
    if (place >= end) return std::nullopt;
    const size_t i = points.Visited(place);
    if (!points.is_there[i]) return std::nullopt;
    return i;
  }

  size_t first, end;  // beyond the last
  size_t stride;
  uint32_t length, count;
  uint32_t lag;  // of each row behind the one above it, in points
};

// How many points the shadow of something half-way up to the light takes to cross a cell: it moves
// by as much as they do. But some cells of each of the light's sides are traced at every point. At
// infinity, where nothing is half-way: 2.
uint32_t ExteriorTurns(const LightSquare& square, uint32_t side, float spacing) {
  if (square.is_at_infinity()) return std::min(2u, side);
  const float cell = square.width() / static_cast<float>(side);
  const auto most = static_cast<float>(std::max(1u, side / 2));
  return static_cast<uint32_t>(std::clamp(spacing > 0 ? cell / spacing : 1.0f, 1.0f, most));
}

// Where on the light the middles of the square's cells are.
struct CellMiddles {
  static constexpr size_t kMax = size_t{CellMask::kMaxSide} * CellMask::kMaxSide + kSamplerLanes;

  CellMiddles(const LightSquare& square, uint32_t side) {
    CellMask::All(side).ForEach([&](uint32_t cell) {
      const Vec2 at(cell % CellMask::kMaxSide, cell / CellMask::kMaxSide);
      const Vec2 place = square.PlaceOf((at + 0.5f) / static_cast<float>(side));
      s[count] = place.x, t[count] = place.y;
      ++count;
    });
  }

  size_t count = 0;
  std::array<float, kMax> s, t;
};

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
        sampling_(SamplingFor(square_, settings)),
        middles_(square_, sampling_.side),
        tiles_(TilesOf(points.width, points.height)) {
    const float spacing = SpacingOf(points);
    sampling_.prediction_distance = PredictionDistanceAt(spacing, square_, settings);
    sampling_.exterior_turns = std::max(
        1u, settings.exterior_turns.value_or(ExteriorTurns(square_, sampling_.side, spacing)));
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
    const auto front = MakeSamplerFront(square_, tracer_, sampling_, settings_.proof);
    for (;;) {
      const size_t next = next_.fetch_add(1, std::memory_order_relaxed);
      if (next >= order_.size()) break;
      Compute(tiles_[order_[next]], *front);
      if (stop_.stop_requested()) break;
    }
  }

  ShadowField Finish() && { return std::move(field_); }

 private:
  void Compute(const PixelRect& tile, SamplerFront& front);
  float Shade(const SurfacePoint& point, const CellMask& visible) const;
  void Report(const PixelRect& tile, const TraceCounts& counts, uint64_t there, uint64_t free);

  const AreaLight& light_;
  const LightSquare square_;
  const SurfacePoints& points_;
  const ShadowTracer& tracer_;
  const ShadowFieldSettings& settings_;
  const std::stop_token& stop_;
  SamplingSettings sampling_;
  const CellMiddles middles_;
  const std::vector<PixelRect> tiles_;
  std::vector<uint32_t> order_;
  std::atomic<size_t> next_ = 0;
  std::mutex mutex_;  // of what follows
  ShadowField field_;
  size_t tiles_done_ = 0;
};

void FieldWork::Compute(const PixelRect& tile, SamplerFront& front) {
  front.Restart();
  uint64_t there = 0, free = 0;
  const TileRows rows(tile, points_);
  for (uint32_t step = 0; step < rows.length + rows.lag * (rows.count - 1); ++step) {
    if (stop_.stop_requested()) return;
    std::array<std::optional<size_t>, SamplerFront::kLanes> at;
    for (uint32_t row = rows.count; row-- > 0;) {
      const uint32_t late = rows.lag * row;
      if (late > step || step - late >= rows.length) continue;
      at[row] = rows.At(row, step - late, points_);
      if (at[row]) front.Begin(row, points_.points[*at[row]], *at[row]);
    }
    front.Finish();
    for (uint32_t row = 0; row < rows.count; ++row) {
      if (!at[row]) continue;
      const CellMask visible = front.visible(row);
      field_.visible[*at[row]] = static_cast<uint16_t>(visible.Count());
      if (settings_.shades) field_.irradiance[*at[row]] = Shade(points_.points[*at[row]], visible);
      ++there;
      free += front.rays(row) == 0;
    }
  }
  Report(tile, front.TakeCounts(), there, free);
}

float FieldWork::Shade(const SurfacePoint& point, const CellMask& visible) const {
  if (visible.empty()) return 0.0f;
  const double unoccluded = UnoccludedFactor(light_, DVec3(point.position), DVec3(point.normal));
  const uint32_t side = sampling_.side;
  if (visible == CellMask::All(side)) return static_cast<float>(unoccluded);
  const LightSquare::Seen seen = square_.From(point.position);
  std::array<float, CellMiddles::kMax> weights;
  seen.WeightsAt(point.normal, middles_.count, middles_.s.data(), middles_.t.data(),
                 weights.data());
  double seen_sum = 0, sum = 0;
  size_t i = 0;
  CellMask::All(side).ForEach([&](uint32_t cell) {
    const double k = weights[i++];
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

float PredictionDistance(const ShadowFieldSettings& settings, const AreaLight& light,
                         const SurfacePoints& points) {
  return PredictionDistanceAt(SpacingOf(points), LightSquare(light), settings);
}

std::vector<PixelRect> TilesOf(uint32_t width, uint32_t height) {
  const uint32_t tile_width =
      height > 1 ? kTileSide : std::clamp(width / kListTiles, kLeastTilePoints, kMostTilePoints);
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
