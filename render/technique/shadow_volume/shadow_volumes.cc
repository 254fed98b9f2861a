#include "render/technique/shadow_volume/shadow_volumes.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "render/artifact/light_extent.h"
#include "render/light_view/make_depth_source.h"
#include "render/light_view/ray_depth_source.h"
#include "render/math/float_text.h"
#include "render/scene/field_error.h"
#include "render/technique/kept_bvhs.h"
#include "render/technique/map_passes.h"
#include "render/technique/shadow_volume/object_volumes.h"
#include "render/technique/shadow_volume/shadow_volume_builder.h"
#include "render/technique/spec_check.h"
#include "render/technique/stopwatch.h"

namespace penumbra {
namespace {

// A high threshold for what is given without one.
constexpr float kHighOverLow = 4.0f;

// Of the places between samples, the part that may have an edge before someone should know: a map
// of a scene that is not finer than it has a tenth of that, one of leaves the half.
constexpr float kManyEdges = 0.5f;

const ShadowVolumeParams& ParamsOf(const ArtifactSpec& spec) {
  return std::get<ShadowVolumeParams>(spec.params);
}

ShadowVolumeOptions OptionsOf(const ShadowVolumeParams& params) {
  ShadowVolumeOptions options{.resolution = params.resolution, .bias_px = params.bias};
  // Given alone, either decides on the other; what is not a number is left to be refused.
  if (params.low_threshold != 0 || params.high_threshold != 0) {
    EdgeThresholds thresholds{.low = params.low_threshold, .high = params.high_threshold};
    if (thresholds.low == 0) thresholds.low = thresholds.high / kHighOverLow;
    if (thresholds.high == 0) {
      thresholds.high = std::min(thresholds.low * kHighOverLow, kMaxEdgeThreshold);
    }
    options.edges.thresholds = thresholds;
  }
  options.has_instance_edges = params.object_ids && params.volumes_of == VolumesOf::kScene;
  options.vectorizes = params.surface == VolumeSurface::kLines;
  if (params.surface == VolumeSurface::kFixed) options.reconstruction = Reconstruction::kFixedMesh;
  if (params.surface == VolumeSurface::kAll) options.reconstruction = Reconstruction::kAllCells;
  return options;
}

// What is kept from revision to revision. Volumes are those of the artifact, with which they share
// their memory; at most the newest is made of some of them.
struct Memory {
  std::shared_ptr<void> bvhs;
  std::optional<ObjectVolumes> volumes;
  bool was_final = false;  // the artifact was made whole once
};

// Of this computation alone where nothing can be kept.
std::shared_ptr<Memory> MemoryOf(const ComputeContext& context) {
  if (context.memory == nullptr) return std::make_shared<Memory>();
  if (context.memory->kept == nullptr) context.memory->kept = std::make_shared<Memory>();
  return std::static_pointer_cast<Memory>(context.memory->kept);
}

// All that one computation has.
class Maker {
 public:
  Maker(const Scene& scene, const ArtifactSpec& spec, const ComputeContext& context)
      : scene_(scene),
        params_(ParamsOf(spec)),
        light_(*scene.FindLight(spec.light_id)),
        context_(context),
        memory_(MemoryOf(context)),
        bvhs_(KeptBvhs(context, &memory_->bvhs)),
        alone_(context.stop) {}

  absl::StatusOr<ShadowVolumeMesh> Make(uint32_t resolution) {
    ShadowVolumeOptions options = OptionsOf(params_);
    options.resolution = resolution;
    return params_.volumes_of == VolumesOf::kScene ? MakeOfAll(options) : MakeOfEach(options);
  }

  // What drew last; of each caster what was to draw.
  const std::string& drawn_by() const { return drawn_by_; }
  // A coarse pass is for who has nothing yet: parts of the final one that stay as they are are not
  // sent again only where nothing came between.
  bool begins_coarse() const { return context_.progress != nullptr && !memory_->was_final; }
  void SetFinal() { memory_->was_final = true; }

 private:
  absl::StatusOr<std::unique_ptr<DepthSource>> SourceOf(const Scene& scene, CasterBvhs& bvhs) {
    return MakeDepthSource(params_.source, scene,
                           {.bvhs = bvhs,
                            .arena = context_.arena,
                            .gl = context_.gl,
                            .gl_error = context_.gl_error,
                            .cpu_for_gl = context_.cpu_for_gl},
                           "source");
  }

  absl::StatusOr<ShadowVolumeMesh> MakeOfAll(const ShadowVolumeOptions& options) {
    const auto source = SourceOf(scene_, bvhs_);
    if (!source.ok()) return source.status();
    const auto instances_of = [this](const LightView& view) {
      return RayDepthSource(bvhs_.Of(scene_), context_.arena).InstancesIn(view, context_.stop);
    };
    auto mesh = BuildShadowVolumes(scene_, light_, options, **source, context_.stop, instances_of);
    drawn_by_ = (*source)->drawn_by();
    return mesh;
  }

  absl::StatusOr<ShadowVolumeMesh> MakeOfEach(const ShadowVolumeOptions& options) {
    const ObjectPrecision precision = params_.volumes_of == VolumesOf::kEdges
                                          ? ObjectPrecision::kWhereItIsLess
                                          : ObjectPrecision::kNever;
    const auto source_of = [this](const Scene& scene) { return SourceOf(scene, alone_); };
    if (options.resolution != params_.resolution) {
      return ObjectVolumes(options, precision).Update(scene_, light_, source_of, context_.stop);
    }
    if (!memory_->volumes) memory_->volumes.emplace(options, precision);
    return memory_->volumes->Update(scene_, light_, source_of, context_.stop);
  }

  const Scene& scene_;
  const ShadowVolumeParams& params_;
  const AreaLight light_;
  const ComputeContext& context_;
  const std::shared_ptr<Memory> memory_;
  CasterBvhs bvhs_;
  CasterBvhs alone_;  // of scenes of one caster, which are not for the store that all share
  std::string drawn_by_{NameOf(params_.source)};
};

ArtifactHeader HeaderFor(const Scene& scene, const ArtifactSpec& spec) {
  const ShadowVolumeParams& params = ParamsOf(spec);
  ArtifactHeader header = HeaderOf(scene, spec);
  header.samples_requested = 1;
  header.light_samples = {MiddleOf(*scene.FindLight(spec.light_id))};
  const auto threshold = [](float value) { return value > 0 ? FloatText(value) : "by the map"; };
  const ShadowVolumeOptions options = OptionsOf(params);
  const EdgeThresholds thresholds =
      options.edges.thresholds.value_or(EdgeThresholds{.low = 0, .high = 0});
  header.parameters = {
      {"bias", FloatText(params.bias)},
      {"low_threshold", threshold(thresholds.low)},
      {"high_threshold", threshold(thresholds.high)},
      {"surface", std::string(NameOf(params.surface))},
      {"volumes_of", std::string(NameOf(params.volumes_of))},
      {"object_ids", options.has_instance_edges ? "true" : "false"},
  };
  return header;
}

// What a pass adds.
void SetPass(const ShadowVolumeMesh& mesh, uint32_t resolution, const std::string& drawn_by,
             ArtifactHeader& header) {
  header.parameters["resolution"] = absl::StrCat(resolution);
  header.parameters["source"] = drawn_by;
  header.parameters["edge_fraction"] = absl::StrFormat("%.4f", mesh.edge_fraction);
  header.parameters.erase("warning");
  if (mesh.edge_fraction <= kManyEdges) return;
  header.parameters["warning"] = absl::StrFormat(
      "there may be an edge at %.0f %% of all places in the light's maps, which "
      "makes large meshes: raise low_threshold and high_threshold, or resolution "
      "where the scene is finer than its map",
      100 * mesh.edge_fraction);
}

// Of two that are given; one alone decides on the other.
absl::Status CheckOrder(const ShadowVolumeParams& params) {
  if (params.high_threshold == 0 || !(params.low_threshold > params.high_threshold)) {
    return absl::OkStatus();
  }
  return FieldError(absl::StatusCode::kInvalidArgument, "RANGE", "shadow_volume.low_threshold",
                    absl::StrCat("found ", params.low_threshold, " above high_threshold ",
                                 params.high_threshold, ", need at most that"));
}

}  // namespace

absl::Status ShadowVolumes::Check(const Scene& scene, const ArtifactSpec& spec) const {
  const auto status = CheckShadowVolumeOptions(OptionsOf(ParamsOf(spec)));
  if (!status.ok()) return Within("shadow_volume.", status);
  if (const auto order = CheckOrder(ParamsOf(spec)); !order.ok()) return order;
  if (const auto target = CheckTarget(spec); !target.ok()) return target;
  if (const auto budget = CheckTimeBudget(spec); !budget.ok()) return budget;
  return CheckOneLight(scene, spec.light_id);
}

bool ShadowVolumes::NeedsGl(const ArtifactSpec& spec) const {
  return ParamsOf(spec).source == DepthMethod::kGl;
}

absl::StatusOr<Artifact> ShadowVolumes::Compute(const Scene& scene, const ArtifactSpec& spec,
                                                const ComputeContext& context) const {
  if (const auto status = Check(scene, spec); !status.ok()) return status;
  Stopwatch watch(context.now_ms);
  Maker maker(scene, spec, context);
  ArtifactHeader header = HeaderFor(scene, spec);
  for (const uint32_t resolution : MapPasses(ParamsOf(spec).resolution, maker.begins_coarse())) {
    auto mesh = maker.Make(resolution);
    if (!mesh.ok()) return Within("shadow_volume.", mesh.status());
    SetPass(*mesh, resolution, maker.drawn_by(), header);
    header.is_final = resolution == ParamsOf(spec).resolution;
    Artifact artifact{.header = header, .payload = *std::move(mesh)};
    artifact.header.timings_ms["compute"] = watch.ElapsedMs();
    ++header.pass;
    if (header.is_final) {
      maker.SetFinal();
      return artifact;
    }
    context.progress(std::move(artifact));
  }
  return absl::InternalError("no pass was the last");
}

}  // namespace penumbra
