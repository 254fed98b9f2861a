// soft_texture by GL: against the CPU's quickest method on the same scene, and many receivers in
// one call against as many calls. Which device GL runs on is printed; on a software device the CPU
// is expected to win.

#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <random>

#include "render/technique/soft_texture/gl/shadow_renderer.h"
#include "render/technique/technique.h"
#include "tests/bench/bench.h"
#include "tests/support/shapes.h"

namespace penumbra::bench {
namespace {

constexpr uint32_t kSamples = 64;
constexpr size_t kBatch = 32;

// The 84 boxes of soft_texture.herf256, over a floor of `texels`².
std::shared_ptr<const Scene> Boxes(uint32_t texels) {
  SceneDelta delta{.upsert_lights = {{.id = "lamp",
                                      .shape = RectangleLight{.corner = Vec3(-1, 8, -1),
                                                              .edge_u = Vec3(2, 0, 0),
                                                              .edge_v = Vec3(0, 0, 2)}}},
                   .upsert_receivers = {testing::FloorReceiver("floor", 10, texels)}};
  std::mt19937 random(1997);
  std::uniform_real_distribution<float> uniform(0, 1);
  const auto box = testing::MeshOf(testing::UnitBoxGeometry());
  for (int i = 0; i < 84; ++i) {
    const float angle = 2 * std::numbers::pi_v<float> * uniform(random);
    const float size = 0.05f + 0.2f * uniform(random);
    const Vec3 x(std::cos(angle), 0, std::sin(angle)), y(0, 1, 0);
    const Vec3 place(10 * uniform(random) - 5, 0.3f + 5 * uniform(random),
                     10 * uniform(random) - 5);
    delta.upsert_instances.push_back(
        {.id = "box" + std::to_string(i),
         .mesh = box,
         .world_from_mesh = Affine(size * x, size * y, size * glm::cross(x, y), place)});
  }
  return Scene::Empty("bench")->Apply(delta).value();
}

std::vector<Row> AgainstCpu(gl::Context& context, bool radiance, const BenchOptions& options) {
  const auto scene = Boxes(256);
  tbb::task_arena arena(options.threads);
  const auto compute = [&](VisibilityMethod method) {
    const ArtifactSpec spec{
        SoftTextureParams{.samples = kSamples, .radiance = radiance, .method = method}, "lamp",
        "floor"};
    return TechniqueFor(spec.params)
        .Compute(*scene, spec, {.arena = arena, .gl = &context})
        .value();
  };
  const auto counts = [](const Artifact& artifact) {
    return std::get<SoftShadowTexture>(artifact.payload).visibility.counts;
  };
  const auto ours = counts(compute(VisibilityMethod::kGl));
  const auto peers = counts(compute(VisibilityMethod::kAuto));
  double differing = 0;
  for (size_t t = 0; t < ours.size(); ++t) differing += std::abs(ours[t] - peers[t]);
  const Duel duel = Interleave(
      options.min_seconds, [&] { (void)compute(VisibilityMethod::kGl); },
      [&] { (void)compute(VisibilityMethod::kAuto); });
  const std::string prefix = radiance ? "soft_texture.gl_radiance." : "soft_texture.gl.";
  return {{prefix + "median", duel.OursMs(), "ms"},
          {prefix + "cpu_median", duel.PeersMs(), "ms"},
          {prefix + "speedup_vs_cpu", duel.Speedup(), "x"},
          {prefix + "differing_fraction", differing / (kSamples * 1.0 * ours.size()), "1"}};
}

std::vector<Row> AgainstSingleCalls(gl::Context& context, const BenchOptions& options) {
  using texture_gl::ShadowRequest;
  const auto scene = Boxes(64);
  const ReceiverPatch receiver = scene->ResolveReceiver("floor").value();
  const auto samples = SampleLight(*scene->FindLight("lamp"), 8, 1, Vec3(0.0f));
  const std::vector<ShadowRequest> requests(kBatch, {*scene, receiver, 1e-5, samples, nullptr});
  texture_gl::ShadowRenderer& renderer = **texture_gl::ShadowRenderer::Of(context);
  const auto draw = [&](std::span<const ShadowRequest> some) {
    (void)renderer.Draw(context, some, {}).value();
  };
  const Duel duel = Interleave(
      options.min_seconds, [&] { draw(requests); },
      [&] {
        for (const ShadowRequest& request : requests) draw(std::span(&request, 1));
      });
  return {{"soft_texture.gl.batch32.median", duel.OursMs(), "ms"},
          {"soft_texture.gl.batch32.single_median", duel.PeersMs(), "ms"},
          {"soft_texture.gl.batch32.speedup_vs_single", duel.Speedup(), "x"}};
}

}  // namespace

std::vector<Row> GlSuite(const BenchOptions& options) {
  const auto context = gl::Context::Create();
  if (!context.ok()) {
    std::fprintf(stderr, "gl: left out, %s\n", std::string(context.status().message()).c_str());
    return {};
  }
  std::fprintf(stderr, "gl: %s\n", (*context)->info().renderer.c_str());
  std::vector<Row> rows = AgainstCpu(**context, false, options);
  for (const auto& more :
       {AgainstCpu(**context, true, options), AgainstSingleCalls(**context, options)}) {
    rows.insert(rows.end(), more.begin(), more.end());
  }
  return rows;
}

}  // namespace penumbra::bench
