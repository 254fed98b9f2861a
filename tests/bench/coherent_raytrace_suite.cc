// Soft shadows of 512 × 512 pixels on self-shadowing models (LitModels), 64 and 256 light samples a
// pixel, jittered for each pixel by itself.
//
// Depth images: hierarchical traversal of images from the light's four corners, 1536 pixels wide,
// without accelerations; with those of rays; with those and coherence-based sampling (Agrawala et
// al. 2000, figure 10); with proofs for parts of the light as well (LightProof). On every eighth
// tile, one after another in turn. rmse_accelerated (with coherence) and rmse_ray_accelerated
// (without) are against no accelerations on these tiles.
//
// Triangles: coherence-based sampling against Embree tracing all samples of the same
// points in packets of 16, cells of 4 × 4 of one point a packet, with or without the coherent
// flag, whichever is faster; on a hierarchy of its own over all triangles, in Embree's fast mode.
// Samples below the horizon or on a light's back cost neither a ray. Building hierarchies is left
// out on both sides, the proof's picture counts for us. RMSE is of attenuation, over the points.

#include <array>
#include <cmath>
#include <memory>

#include "render/light_view/raster_depth_source.h"
#include "render/math/parallel_for.h"
#include "render/technique/coherent_raytrace/depth_image_tracer.h"
#include "render/technique/coherent_raytrace/light_proof.h"
#include "render/technique/coherent_raytrace/reference_images.h"
#include "render/technique/coherent_raytrace/shadow_field.h"
#include "render/technique/coherent_raytrace/triangle_tracer.h"
#include "tests/bench/bench.h"
#include "tests/bench/coherent_raytrace_scenes.h"
#include "tests/support/packet_rays.h"

namespace penumbra::bench {
namespace {

constexpr uint32_t kPixels = 512;
constexpr uint64_t kSeed = 1;
constexpr uint32_t kTilesLeftOut = 8;  // of as many all but one

struct Case {
  const LitModel& model;
  const testing::PacketRays& peer;
  const SurfacePoints& points;
  float surface_offset;
  uint32_t side;
  tbb::task_arena& arena;
};

std::vector<uint16_t> TraceAll(const Case& c, bool is_coherent) {
  return c.peer.VisibleFrom(c.points,
                            {.light = c.model.light,
                             .side = c.side,
                             .seed = kSeed,
                             .surface_offset = c.surface_offset,
                             .is_coherent = is_coherent},
                            c.arena);
}

std::vector<uint32_t> SomeTiles(std::span<const PixelRect> tiles) {
  std::vector<uint32_t> some;
  for (uint32_t i = 0; i < tiles.size(); ++i) {
    // Shifted from row to row, so that each column has its share.
    if ((i + 3 * (tiles[i].y / 32)) % kTilesLeftOut == 0) some.push_back(i);
  }
  return some;
}

double Rmse(const Case& c, const std::vector<uint16_t>& a, const std::vector<uint16_t>& b,
            const std::vector<uint16_t>* only_in = nullptr) {
  double sum2 = 0, count = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    if (!c.points.is_there[i] || (only_in && (*only_in)[i] == 0)) continue;
    const double off = (static_cast<double>(a[i]) - static_cast<double>(b[i])) / (c.side * c.side);
    sum2 += off * off, ++count;
  }
  return std::sqrt(sum2 / std::max(count, 1.0));
}

ShadowField Compute(const Case& c, const ShadowTracer& tracer, bool predicts,
                    const LightProof* proof, bool some_tiles) {
  ShadowFieldSettings settings{.sampling = {.side = c.side, .seed = kSeed, .predicts = predicts},
                               .shades = false,
                               .proof = proof};
  if (some_tiles) settings.tile_order = SomeTiles;
  return OrDie(ComputeShadowField(c.model.light, c.points, tracer, settings, c.arena));
}

double RaysOf(const ShadowField& field) {
  return static_cast<double>(field.counts.rays) /
         static_cast<double>(std::max<uint64_t>(field.points, 1));
}

// 1 at the points of SomeTiles.
std::vector<uint16_t> MaskOfSomeTiles(const SurfacePoints& points) {
  std::vector<uint16_t> mask(points.size());
  const std::vector<PixelRect> tiles = TilesOf(points.width, points.height);
  for (const uint32_t t : SomeTiles(tiles)) {
    for (uint32_t k = 0; k < tiles[t].width * tiles[t].height; ++k) {
      mask[size_t{tiles[t].y + k / tiles[t].width} * points.width + tiles[t].x +
           k % tiles[t].width] = 1;
    }
  }
  return mask;
}

std::vector<Row> DepthImageRows(const Case& c, const std::string& prefix, const std::string& suffix,
                                const std::vector<uint16_t>& truth) {
  RasterDepthSource source(*c.model.scene, c.arena);
  const auto images =
      OrDie(DrawReferenceImages(c.model.light, *c.model.scene, {}, source, c.arena));
  const DepthImageTracer plain(images, RayAccelerations::None()), fast(images, {});
  const LightProof proof(c.model.light, *c.model.scene, {}, c.arena);
  std::array<std::vector<double>, 4> times;
  std::array<ShadowField, 4> fields;
  for (int round = 0; round < 3; ++round) {
    for (int way = 0; way < 4; ++way) {
      const double start = NowMs();
      fields[way] = Compute(c, way == 0 ? static_cast<const ShadowTracer&>(plain) : fast, way >= 2,
                            way == 3 ? &proof : nullptr, true);
      times[way].push_back(NowMs() - start);
    }
  }
  const auto speedup = [&](int way) { return Median(times[0]) / Median(times[way]); };
  const std::vector<uint16_t> some = MaskOfSomeTiles(c.points);
  const ShadowField whole = Compute(c, fast, true, nullptr, false);
  return {{prefix + "ray_acceleration_speedup" + suffix, speedup(1), "x"},
          {prefix + "coherence_speedup" + suffix, speedup(2), "x"},
          {prefix + "proof_speedup" + suffix, speedup(3), "x"},
          {prefix + "mean_rays" + suffix, RaysOf(whole), "1"},
          {prefix + "mean_rays_with_proof" + suffix, RaysOf(fields[3]), "1"},
          {prefix + "rmse_accelerated" + suffix,
           Rmse(c, fields[2].visible, fields[0].visible, &some), "1"},
          {prefix + "rmse_ray_accelerated" + suffix,
           Rmse(c, fields[1].visible, fields[0].visible, &some), "1"},
          {prefix + "depth_image_rmse_vs_embree" + suffix, Rmse(c, whole.visible, truth), "1"},
          {prefix + "rmse_unaccelerated_vs_embree" + suffix,
           Rmse(c, fields[0].visible, truth, &some), "1"}};
}

std::vector<Row> TriangleRows(const Case& c, const std::string& prefix, const std::string& suffix,
                              const BenchOptions& options, std::vector<uint16_t>& truth) {
  CasterBvhs bvhs;
  const TriangleTracer tracer(bvhs.Flat(*c.model.scene), c.surface_offset);
  ShadowField field;
  const auto ours = [&] { field = Compute(c, tracer, true, nullptr, false); };
  const double start = NowMs();
  truth = TraceAll(c, true);
  const double middle = NowMs();
  TraceAll(c, false);
  const bool is_coherent = middle - start < NowMs() - middle;
  const Duel duel = Interleave(0.5 * options.min_seconds, ours, [&] { TraceAll(c, is_coherent); });
  const ShadowField all = Compute(c, tracer, false, nullptr, false);
  return {{prefix + "speedup_vs_embree" + suffix, duel.Speedup(), "x"},
          {prefix + "rmse_vs_embree" + suffix, Rmse(c, field.visible, truth), "1"},
          {prefix + "rmse_all_rays_vs_embree" + suffix, Rmse(c, all.visible, truth), "1"},
          {prefix + "triangle_mean_rays" + suffix, RaysOf(field), "1"}};
}

}  // namespace

std::vector<Row> CoherentRaytraceSuite(const BenchOptions& options) {
  std::vector<Row> rows;
  tbb::task_arena arena(options.threads);
  for (const LitModel& model : LitModels()) {
    CasterBvhs bvhs;
    const auto seen = bvhs.Of(*model.scene, CasterBvhs::Instances::kAll);
    const testing::PacketRays peer(*model.scene);
    const SurfacePoints points = OrDie(
        VisiblePoints(*seen, {.camera = model.camera, .width = kPixels, .height = kPixels}, arena));
    const std::string prefix = "coherent_raytrace." + model.name + ".";
    std::array<double, 2> rays{};
    for (const uint32_t side : {8u, 16u}) {
      const Case c{model, peer, points, SurfaceOffset(model.scene->Bounds()), side, arena};
      const std::string suffix = side == 8 ? "_64" : "";
      std::vector<uint16_t> truth;
      std::vector<Row> more = TriangleRows(c, prefix, suffix, options, truth);
      rows.insert(rows.end(), more.begin(), more.end());
      more = DepthImageRows(c, prefix, suffix, truth);
      rays[side / 16] = more[3].value;
      rows.insert(rows.end(), more.begin(), more.end());
    }
    rows.push_back({prefix + "rays_256_over_64", rays[1] / rays[0], "x"});
  }
  return rows;
}

}  // namespace penumbra::bench
