// The shadows of one light at many points: the final picture.
//
//   auto field = ComputeShadowField(light, points, tracer, {.sampling = {.side = 16}}, arena);
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "absl/status/statusor.h"
#include "render/scene/area_light.h"
#include "render/technique/coherent_raytrace/sampling_settings.h"
#include "render/technique/coherent_raytrace/shadow_tracer.h"
#include "render/technique/coherent_raytrace/surface_points.h"
#include "tbb/task_arena.h"

namespace penumbra {

class LightProof;

struct TileDone {
  PixelRect tile;  // of a list: of the places in its order
  size_t tiles_done = 0;
  size_t tiles = 0;
  uint64_t rays = 0;  // traced so far
};

// H×W, as the points.
struct ShadowField {
  uint32_t sample_count = 0;      // n
  std::vector<uint16_t> visible;  // samples seen, 0 … n; equation (2) times n
  // Reflected by a white surface, for a light of strength 1 (LightStrength): equation (1).
  std::vector<float> irradiance;  // empty if not asked for
  TraceCounts counts;
  uint64_t points = 0;       // that are there
  uint64_t free_points = 0;  // that took no ray
  float prediction_distance = 0.0f;
};

struct ShadowFieldSettings {
  SamplingSettings sampling;  // but for its prediction_distance and exterior_turns
  // Chosen from the points' spacing and the light's width when not given, in m.
  std::optional<float> prediction_distance;
  // SamplingSettings::exterior_turns, chosen from the points' spacing when not given.
  std::optional<uint32_t> exterior_turns;
  bool shades = true;
  // What is known without rays; null: nothing.
  const LightProof* proof = nullptr;
  // The order in which tiles are begun, as places in `tiles`; those left out are not computed.
  // Null: rows from the top.
  std::function<std::vector<uint32_t>(std::span<const PixelRect> tiles)> tile_order;
  // Called after each tile, from any thread but not from two at once, with what is done so far: of
  // tiles that were not told of yet it may hold anything.
  std::function<void(const TileDone&, const ShadowField& so_far)> on_tile;
};

// From a point further than this, in m, from the one before nothing is predicted.
float PredictionDistance(const ShadowFieldSettings& settings, const AreaLight& light,
                         const SurfacePoints& points);

// Tiles begin afresh, so that the same points, light and settings give the same bits for any number
// of threads and any order of tiles.
//
//   E / L = F · Σ_i k_i V_i / Σ_i k_i,   k = cos θ cos θ' / r²,
//
// with F the form factor in closed form.
//
// Errors  kInvalidArgument, RANGE: "samples.side"; kCancelled (asked once in 32 points)
// Source  Agrawala et al. 2000, §5.2 and equations (1) and (2); departs: the sum of equation (1) is
//         divided by the same sum without V and multiplied by its known value, so that what is lit
//         by all of the light has no noise; k is that of the cells' middles
absl::StatusOr<ShadowField> ComputeShadowField(const AreaLight& light, const SurfacePoints& points,
                                               const ShadowTracer& tracer,
                                               const ShadowFieldSettings& settings,
                                               tbb::task_arena& arena,
                                               const std::stop_token& stop = {});

// The tiles that points are computed in.
std::vector<PixelRect> TilesOf(uint32_t width, uint32_t height);

}  // namespace penumbra
