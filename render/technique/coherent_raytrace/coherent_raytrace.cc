#include "render/technique/coherent_raytrace/coherent_raytrace.h"

#include <memory>
#include <optional>
#include <utility>
#include <variant>

#include "render/light_view/auto_depth_source.h"
#include "render/technique/coherent_raytrace/coherent_params.h"
#include "render/technique/coherent_raytrace/depth_image_tracer.h"
#include "render/technique/coherent_raytrace/light_proof.h"
#include "render/technique/coherent_raytrace/picture_in_the_making.h"
#include "render/technique/coherent_raytrace/receiver_points.h"
#include "render/technique/coherent_raytrace/reference_images.h"
#include "render/technique/coherent_raytrace/shadow_field.h"
#include "render/technique/coherent_raytrace/triangle_tracer.h"
#include "render/technique/kept_bvhs.h"
#include "render/technique/passes.h"
#include "render/technique/spec_check.h"

namespace penumbra {
namespace {

const CoherentRaytraceParams& ParamsOf(const ArtifactSpec& spec) {
  return std::get<CoherentRaytraceParams>(spec.params);
}

float BiasOf(const CoherentRaytraceParams& params, const Scene& scene) {
  return params.shadow_bias > 0 ? params.shadow_bias : SurfaceOffset(scene.Bounds());
}

// Errors  those of DrawReferenceImages, the status of a CasterBvh
absl::StatusOr<std::unique_ptr<ShadowTracer>> MakeTracer(const Scene& scene, const AreaLight& light,
                                                         const CoherentRaytraceParams& params,
                                                         CasterBvhs& bvhs,
                                                         const ComputeContext& context) {
  if (params.backend != RayBackend::kDepthImages) {
    auto casters = bvhs.Flat(scene);
    if (!casters->status().ok()) return casters->status();
    return std::make_unique<TriangleTracer>(std::move(casters), BiasOf(params, scene));
  }
  ReferenceImageSettings settings{.pixels = params.resolution};
  if (params.gap_bias > 0) settings.gap.metres = params.gap_bias;
  AutoDepthSource source(scene, bvhs, context.arena);
  auto images = DrawReferenceImages(light, scene, settings, source, context.arena, context.stop);
  if (!images.ok()) return images.status();
  SelfShadowBias bias;
  if (params.shadow_bias > 0) bias.metres = params.shadow_bias;
  return std::make_unique<DepthImageTracer>(
      *std::move(images), params.ray_accelerations ? RayAccelerations{} : RayAccelerations::None(),
      bias);
}

ShadowFieldSettings SettingsOf(const CoherentRaytraceParams& params, const AreaLight& light,
                               const PointReceiver& points) {
  ShadowFieldSettings settings{
      .sampling = {.side = SideOf(params, light),
                   .seed = params.seed,
                   .predicts = params.coherence},
      .shades = params.radiance,
      .tile_order = [&](std::span<const PixelRect> tiles) { return TileOrder(points, tiles); }};
  if (params.prediction_distance > 0) settings.prediction_distance = params.prediction_distance;
  return settings;
}

// The points of GivenPoints are left out: whoever asked has them.
PointReceiver WithoutGivenPoints(const PointReceiver& receiver) {
  return std::holds_alternative<GivenPoints>(receiver) ? PointReceiver(GivenPoints{}) : receiver;
}

ArtifactHeader HeaderFor(const Scene& scene, const ArtifactSpec& spec, const AreaLight& light,
                         const ShadowFieldSettings& settings, const SurfacePoints& points) {
  const CoherentRaytraceParams& params = ParamsOf(spec);
  ArtifactHeader header = HeaderOf(scene, spec);
  const uint32_t side = settings.sampling.side;
  header.samples_requested = side * side;
  header.error_estimate = ErrorEstimate(side * side, side > 1);
  header.parameters = EffectiveParameters(params, side, BiasOf(params, scene),
                                          PredictionDistance(settings, light, points));
  return header;
}

}  // namespace

absl::Status CoherentRaytrace::Check(const Scene& scene, const ArtifactSpec& spec) const {
  if (const auto status = CheckParams(ParamsOf(spec)); !status.ok()) return status;
  if (const auto status = CheckTarget(spec); !status.ok()) return status;
  if (const auto status = CheckTimeBudget(spec); !status.ok()) return status;
  if (const auto status = CheckOneLight(scene, spec.light_id); !status.ok()) return status;
  return CheckOn(scene, *spec.points);
}

absl::StatusOr<Artifact> CoherentRaytrace::Compute(const Scene& scene, const ArtifactSpec& spec,
                                                   const ComputeContext& context) const {
  if (const auto status = Check(scene, spec); !status.ok()) return status;
  const CoherentRaytraceParams& params = ParamsOf(spec);
  const auto light = scene.FindLight(spec.light_id);
  CasterBvhs bvhs = KeptBvhs(context);
  const auto points = PointsOf(scene, *spec.points, bvhs, context.arena, context.stop);
  if (!points.ok()) return Within("points.", points.status());
  const auto tracer = MakeTracer(scene, *light, params, bvhs, context);
  if (!tracer.ok()) return Within("coherent_raytrace.", tracer.status());

  ShadowFieldSettings settings = SettingsOf(params, *light, *spec.points);
  std::optional<LightProof> proof;
  // Rays against triangles are quicker than what it saves of them.
  const bool pays = params.backend == RayBackend::kDepthImages && settings.sampling.side > 1;
  if (params.whole_light && pays) {
    proof.emplace(*light, scene, ProofSettings{}, context.arena, context.stop);
    settings.proof = &*proof;
  }
  ViewShadow view;
  view.points = WithoutGivenPoints(*spec.points);
  view.light = *light;
  if (params.radiance) view.radiance.emplace();
  PictureInTheMaking picture(HeaderFor(scene, spec, *light, settings, *points), std::move(view),
                             *points, params.output, context);
  settings.on_tile = [&](const TileDone& done, const ShadowField& so_far) {
    picture.Add(done, so_far);
  };
  const auto field =
      ComputeShadowField(*light, *points, **tracer, settings, context.arena, context.stop);
  if (!field.ok()) return field.status();
  return std::move(picture).Finish(*field);
}

}  // namespace penumbra
