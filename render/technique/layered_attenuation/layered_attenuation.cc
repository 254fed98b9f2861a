#include "render/technique/layered_attenuation/layered_attenuation.h"

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/light_view/auto_depth_source.h"
#include "render/light_view/make_depth_source.h"
#include "render/light_view/shadowless_surfaces.h"
#include "render/math/float_text.h"
#include "render/scene/field_error.h"
#include "render/technique/kept_bvhs.h"
#include "render/technique/layered_attenuation/ldi_passes.h"
#include "render/technique/passes.h"
#include "render/technique/spec_check.h"
#include "render/technique/stopwatch.h"

namespace penumbra {
namespace {

const LayeredAttenuationParams& ParamsOf(const ArtifactSpec& spec) {
  return std::get<LayeredAttenuationParams>(spec.params);
}

LdiOptions OptionsOf(const LayeredAttenuationParams& params) {
  return {.samples = params.samples,
          .seed = params.seed,
          .resolution = params.resolution,
          .tolerance = params.tolerance == 0 ? std::nullopt : std::optional(params.tolerance),
          .key_views = params.key_views,
          .limits = {.max_layers = params.max_layers}};
}

absl::Status CheckParams(const LayeredAttenuationParams& params) {
  if (params.max_layers < 1 || params.max_layers > kMaxLdiLayers) {
    return FieldError(absl::StatusCode::kInvalidArgument, "RANGE", "layered_attenuation.max_layers",
                      absl::StrCat("found ", params.max_layers, ", need 1 to ", kMaxLdiLayers));
  }
  return Within("layered_attenuation.", CheckLdiOptions(OptionsOf(params)));
}

ArtifactHeader HeaderFor(const Scene& scene, const ArtifactSpec& spec, const LdiPasses& passes) {
  const auto& params = ParamsOf(spec);
  ArtifactHeader header = HeaderOf(scene, spec);
  header.samples_requested = passes.sample_count();
  header.parameters = {
      {"samples", absl::StrCat(passes.sample_count())},
      {"seed", absl::StrCat(params.seed)},
      {"resolution", absl::StrCat(params.resolution)},
      {"tolerance", FloatText(passes.tolerance())},
      {"key_views", params.key_views ? "true" : "false"},
      {"max_layers", absl::StrCat(params.max_layers)},
  };
  return header;
}

// How many samples the first pass counts.
uint32_t FirstPass(const ArtifactSpec& spec, const ComputeContext& context, uint32_t samples) {
  if (!context.progress) return samples;
  return FirstPassSamples(spec.time_budget_ms, context.memory ? &context.memory->pace : nullptr);
}

// All passes: the coarse ones go to the context's progress.
absl::StatusOr<Artifact> RunPasses(LdiPasses& passes, const DepthSource& source,
                                   ArtifactHeader header, const ArtifactSpec& spec,
                                   const ComputeContext& context) {
  Stopwatch watch(context.now_ms);
  const uint32_t n = passes.sample_count(), first = FirstPass(spec, context, n);
  double compute_ms = 0;
  for (;; watch.Restart()) {
    const auto status = passes.Advance(NextPassEnd(passes.done(), first, n), context.stop);
    if (!status.ok()) return Within("layered_attenuation.", status);
    header.parameters["source"] = source.drawn_by();
    header.light_samples = passes.samples_done();
    header.is_final = passes.done() == n;
    header.error_estimate = ErrorEstimate(passes.done(), n > 1);
    Artifact artifact{.header = header, .payload = passes.Finish()};
    compute_ms += watch.ElapsedMs();
    artifact.header.timings_ms["compute"] = compute_ms;
    if (header.pass++ == 0 && context.memory) context.memory->pace.Learn(passes.done(), compute_ms);
    if (header.is_final) return artifact;
    context.progress(std::move(artifact));
  }
}

}  // namespace

absl::Status LayeredAttenuation::Check(const Scene& scene, const ArtifactSpec& spec) const {
  if (const auto status = CheckParams(ParamsOf(spec)); !status.ok()) return status;
  if (const auto status = CheckTarget(spec); !status.ok()) return status;
  if (const auto status = CheckTimeBudget(spec); !status.ok()) return status;
  return CheckOneLight(scene, spec.light_id);
}

bool LayeredAttenuation::NeedsGl(const ArtifactSpec& spec) const {
  return ParamsOf(spec).source == DepthMethod::kGl;
}

absl::StatusOr<Artifact> LayeredAttenuation::Compute(const Scene& scene, const ArtifactSpec& spec,
                                                     const ComputeContext& context) const {
  if (const auto status = Check(scene, spec); !status.ok()) return status;
  CasterBvhs bvhs = KeptBvhs(context);
  const auto source = MakeDepthSource(ParamsOf(spec).source, scene,
                                      {.bvhs = bvhs,
                                       .arena = context.arena,
                                       .gl = context.gl,
                                       .gl_error = context.gl_error,
                                       .cpu_for_gl = context.cpu_for_gl},
                                      "layered_attenuation.source");
  if (!source.ok()) return source.status();
  // These are drawn a few times each: by whatever needs no context.
  CasterBvhs surface_bvhs(context.stop);
  std::vector<std::unique_ptr<AutoDepthSource>> surface_sources;
  std::vector<SeenSurface> surfaces;
  for (auto& surface : SurfacesWithoutShadows(scene)) {
    surface_sources.push_back(
        std::make_unique<AutoDepthSource>(*surface, surface_bvhs, context.arena));
    surfaces.push_back({.scene = std::move(surface), .source = surface_sources.back().get()});
  }
  const auto light = scene.FindLight(spec.light_id);
  auto passes = LdiPasses::Create(scene, *light, OptionsOf(ParamsOf(spec)), **source, context.arena,
                                  std::move(surfaces));
  if (!passes.ok()) return Within("layered_attenuation.", passes.status());
  return RunPasses(**passes, **source, HeaderFor(scene, spec, **passes), spec, context);
}

}  // namespace penumbra
