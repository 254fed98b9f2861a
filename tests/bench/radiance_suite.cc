// Radiance of soft_texture: how far its two formulas are from the truth and from each other, for
// lights from small to large, and what each costs.
//
// Errors are in relation to the radiance that a texel has with nothing in the way; those in the
// umbra would else be divided by nothing. The truth is a sum over 64 × 64 evenly spread points of
// the light in double precision, each seen or not by Embree.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "render/artifact/unoccluded_texture.h"
#include "render/reference/light_integral.h"
#include "render/reference/light_quadrature.h"
#include "render/reference/ray_visibility.h"
#include "render/technique/technique.h"
#include "tests/bench/bench.h"
#include "tests/support/shapes.h"

namespace penumbra::bench {
namespace {

constexpr float kLightHeight = 2;
constexpr uint32_t kErrorTexels = 64;
constexpr uint32_t kErrorSamples = 1024;
constexpr uint32_t kPointsPerSide = 64;

AreaLight SquareLamp(float side) {
  return {.id = "lamp",
          .shape = RectangleLight{.corner = Vec3(-side / 2, kLightHeight, -side / 2),
                                  .edge_u = Vec3(side, 0, 0),
                                  .edge_v = Vec3(0, 0, side)}};
}

// Boxes that stand on a floor of 4 m, that float half way up to the lamp, and a wall beside it.
SceneDelta Room(float light_side, uint32_t texels) {
  SceneDelta delta;
  delta.upsert_receivers = {testing::FloorReceiver("floor", 4, texels)};
  delta.upsert_lights = {SquareLamp(light_side)};
  const auto box = testing::MeshOf(testing::UnitBoxGeometry());
  std::mt19937 random(41);
  std::uniform_real_distribution<float> uniform(-1, 1);
  for (int i = 0; i < 24; ++i) {
    const float half = 0.08f + 0.04f * uniform(random);
    const float height = i % 3 == 0 ? half : 0.7f + 0.4f * uniform(random);
    const Vec3 place(1.7f * uniform(random), height, 1.7f * uniform(random));
    delta.upsert_instances.push_back({.id = "box" + std::to_string(i),
                                      .mesh = box,
                                      .world_from_mesh = testing::Placed(place, half)});
  }
  delta.upsert_instances.push_back(
      {.id = "wall",
       .mesh = box,
       .world_from_mesh = testing::Placed(Vec3(-1.2f, 0.5f, 0.2f), Vec3(0.03f, 0.5f, 0.9f))});
  return delta;
}

SoftTextureParams Params(Shading shading, uint32_t samples, float form_factor_error) {
  return {.samples = samples,
          .radiance = true,
          .shading = shading,
          .form_factor_error = form_factor_error};
}

Artifact Compute(const Scene& scene, const SoftTextureParams& params, tbb::task_arena& arena) {
  const ArtifactSpec spec{params, "lamp", "floor"};
  return TechniqueFor(spec.params).Compute(scene, spec, {.arena = arena}).value();
}

using Values = std::vector<double>;

Values RadianceOf(const Artifact& artifact) {
  Values values;
  for (const Vec3 texel : std::get<SoftShadowTexture>(artifact.payload).radiance->texels) {
    values.push_back(texel.x);
  }
  return values;
}

class Truth {
 public:
  Truth(const Scene& scene, const ReceiverPatch& receiver, double surface_offset,
        tbb::task_arena& arena)
      : rays_(scene, RayVisibility::Intersector::kRobust),
        light_(*scene.FindLight("lamp")),
        receiver_(receiver),
        surface_offset_(surface_offset),
        arena_(arena) {}

  Values Radiance(std::span<const QuadraturePoint> points) const {
    std::vector<LightSample> samples;
    for (const QuadraturePoint& point : points) samples.push_back(point.sample);
    const auto blocked = rays_.Blocked(receiver_, samples, surface_offset_, arena_);
    const size_t texels = size_t{receiver_.width} * receiver_.height;
    Values values;
    std::vector<uint8_t> visible(points.size());
    for (uint32_t t = 0; t < texels; ++t) {
      for (size_t s = 0; s < points.size(); ++s) visible[s] = !blocked[s * texels + t];
      values.push_back(DirectRadiance(light_, points, CenterOf(t), DVec3(0, 1, 0), visible).x);
    }
    return values;
  }
  Values Unoccluded() const {
    Values values;
    for (uint32_t t = 0; t < receiver_.width * receiver_.height; ++t) {
      values.push_back(IntegratedRadiance(light_, CenterOf(t), DVec3(0, 1, 0)).x);
    }
    return values;
  }

 private:
  DVec3 CenterOf(uint32_t t) const {
    return DVec3(receiver_.patch.origin) +
           (t % receiver_.width + 0.5) / receiver_.width * DVec3(receiver_.patch.edge_u) +
           (t / receiver_.width + 0.5) / receiver_.height * DVec3(receiver_.patch.edge_v);
  }

  const RayVisibility rays_;
  const AreaLight light_;
  const ReceiverPatch receiver_;
  const double surface_offset_;
  tbb::task_arena& arena_;
};

void AddErrors(const std::string& prefix, const Values& a, const Values& b, const Values& unit,
               std::vector<Row>& rows) {
  double worst = 0, sum2 = 0;
  for (size_t t = 0; t < a.size(); ++t) {
    const double error = std::abs(a[t] - b[t]) / unit[t];
    worst = std::max(worst, error);
    sum2 += error * error;
  }
  rows.push_back({prefix + ".max_error", worst, "1"});
  rows.push_back({prefix + ".rms_error", std::sqrt(sum2 / static_cast<double>(a.size())), "1"});
}

// One size of the light, given as side over height.
void AddErrorRows(double size, tbb::task_arena& arena, std::vector<Row>& rows) {
  const auto scene = Scene::Empty("bench")
                         ->Apply(Room(static_cast<float>(size) * kLightHeight, kErrorTexels))
                         .value();
  const Artifact sum = Compute(*scene, Params(Shading::kSampleSum, kErrorSamples, 0), arena);
  const Artifact product = Compute(*scene, Params(Shading::kProduct, kErrorSamples, 0), arena);
  const auto& texture = std::get<SoftShadowTexture>(sum.payload);
  const double offset = std::stod(sum.header.parameters.at("surface_offset_m"));
  const Truth truth(*scene, texture.receiver, offset, arena);
  const Values unit = truth.Unoccluded();
  const Values dense = truth.Radiance(LightQuadrature(texture.light, kPointsPerSide));
  const Values same =
      truth.Radiance(MeasuredSamples(texture.light, sum.header.light_samples, DVec3(0.0)));
  char name[64];
  std::snprintf(name, sizeof(name), "radiance.light_%g", size);
  const std::string prefix = name;
  AddErrors(prefix + ".sum_vs_double", RadianceOf(sum), same, unit, rows);
  AddErrors(prefix + ".sum_vs_truth", RadianceOf(sum), dense, unit, rows);
  AddErrors(prefix + ".product_vs_sum", RadianceOf(product), RadianceOf(sum), unit, rows);
  AddErrors(prefix + ".product_vs_truth", RadianceOf(product), dense, unit, rows);
}

void AddTimes(const BenchOptions& options, tbb::task_arena& arena, std::vector<Row>& rows) {
  const auto scene = Scene::Empty("bench")->Apply(Room(1, 256)).value();
  const auto compute = [&](const SoftTextureParams& params) {
    return [&arena, &scene, params] { (void)Compute(*scene, params, arena); };
  };
  const auto product = compute(Params(Shading::kProduct, 64, 1e-3f));
  const Duel counts = Interleave(options.min_seconds, product, compute({.samples = 64}));
  const Duel sum =
      Interleave(options.min_seconds, compute(Params(Shading::kSampleSum, 64, 1e-3f)), product);
  const std::string prefix = "soft_texture.shading.";
  rows.push_back({prefix + "counts.median", counts.PeersMs(), "ms"});
  rows.push_back({prefix + "product.median", counts.OursMs(), "ms"});
  rows.push_back({prefix + "sample_sum.median", sum.OursMs(), "ms"});
  rows.push_back({prefix + "sample_sum.overhead_vs_product", 1 / sum.Speedup(), "x"});

  const auto receiver = scene->ResolveReceiver("floor").value();
  const AreaLight light = *scene->FindLight("lamp");
  const auto factors = [&](double error) {
    return [&arena, &light, &receiver, error] {
      arena.execute([&] {
        UnoccludedTexture(light, receiver, error).ForEachBlock({}, [](const auto&, auto) {});
      });
    };
  };
  for (const auto& [name, error] : {std::pair{"1e-3", 1e-3}, std::pair{"1e-4", 1e-4}}) {
    const Duel duel = Interleave(options.min_seconds, factors(error), factors(0));
    const std::string form_factor = prefix + "form_factor_" + name;
    rows.push_back({form_factor + ".median", duel.OursMs(), "ms"});
    rows.push_back({form_factor + ".every_texel_median", duel.PeersMs(), "ms"});
    rows.push_back({form_factor + ".speedup_vs_every_texel", duel.Speedup(), "x"});
  }
}

}  // namespace

std::vector<Row> RadianceSuite(const BenchOptions& options) {
  tbb::task_arena arena(options.threads);
  std::vector<Row> rows;
  for (const double size : {0.05, 0.2, 0.5, 1.0, 2.0}) AddErrorRows(size, arena, rows);
  AddTimes(options, arena, rows);
  return rows;
}

}  // namespace penumbra::bench
