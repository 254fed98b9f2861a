#include "render/technique/shadow_width/shadow_width.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "render/artifact/light_extent.h"
#include "render/light_view/light_face.h"
#include "render/light_view/make_depth_source.h"
#include "render/light_view/no_gl.h"
#include "render/light_view/shadow_layers.h"
#include "render/light_view/shadowless_surfaces.h"
#include "render/light_view/view_fit.h"
#include "render/math/float_text.h"
#include "render/scene/field_error.h"
#include "render/technique/kept_bvhs.h"
#include "render/technique/map_passes.h"
#include "render/technique/shadow_width/distance_exact.h"
#include "render/technique/shadow_width/distance_steps_cpu.h"
#include "render/technique/shadow_width/distance_sweep.h"
#include "render/technique/shadow_width/gl/distance_steps.h"
#include "render/technique/shadow_width/width_face.h"
#include "render/technique/spec_check.h"
#include "render/technique/stopwatch.h"

namespace penumbra {
namespace {

// The part of a window by which a face that others are beside sees more to each side: shadows of
// what is there reach across the border, and their widths with them.
constexpr double kMargin = 0.125;

// Of the face's window: pixels small enough to find out how large what is seen is.
constexpr double kFinest = 1.0 / 4096;

const ShadowWidthParams& ParamsOf(const ArtifactSpec& spec) {
  return std::get<ShadowWidthParams>(spec.params);
}

absl::Status RangeError(const char* field, const std::string& found, const std::string& need) {
  return FieldError(absl::StatusCode::kInvalidArgument, "RANGE",
                    absl::StrCat("shadow_width.", field),
                    absl::StrCat("found ", found, ", need ", need));
}

absl::Status CheckNumber(const char* field, float found, float most) {
  if (found >= 0 && found <= most) return absl::OkStatus();
  return RangeError(field, absl::StrFormat("%g", found), absl::StrFormat("0 to %g", most));
}

absl::Status CheckParams(const ShadowWidthParams& params) {
  if (params.resolution < kMinWidthResolution || params.resolution > kMaxWidthResolution) {
    return RangeError("resolution", absl::StrCat(params.resolution),
                      absl::StrCat(kMinWidthResolution, " to ", kMaxWidthResolution));
  }
  if (params.layers < 1 || params.layers > kMaxWidthLayers) {
    return RangeError("layers", absl::StrCat(params.layers), "1 or 2");
  }
  absl::Status status = CheckNumber("c_scale", params.c_scale, kMaxCScale);
  status.Update(CheckNumber("c_bias", params.c_bias, kMaxCBias));
  return status;
}

bool NeedsGlFor(DistanceMethod method) {
  return method == DistanceMethod::kGlThree || method == DistanceMethod::kGlSix;
}

double LongerSide(const Window& window) { return std::max(window.size().x, window.size().y); }

LightFace WithMargin(LightFace face) {
  const DVec2 margin = kMargin * face.window.size();
  face.window = {face.window.min - margin, face.window.max + margin};
  return face;
}

// All that one computation has.
class Maker {
 public:
  Maker(const Scene& scene, const Scene& all_surfaces, const ArtifactSpec& spec,
        DepthSource& source, const CasterBvhs& bvhs, const ComputeContext& context)
      : params_(ParamsOf(spec)),
        light_(*scene.FindLight(spec.light_id)),
        source_(source),
        tracer_(scene, all_surfaces, bvhs, context.arena),
        context_(context) {
    for (const auto& [id, instance] : all_surfaces.instances()) {
      const Aabb box = WorldBounds(*instance);
      if ((instance->casts || instance->receives) && !box.empty()) boxes_.push_back(box);
    }
    Aabb bounds;
    for (const Aabb& box : boxes_) bounds.Add(box);
    faces_ = FacesOf(light_, bounds);
  }

  // Errors  kResourceExhausted QUOTA_WIDTH_TEXELS, "resolution"
  absl::StatusOr<ShadowWidthMap> Make(uint32_t resolution) {
    ShadowWidthMap map{.light = light_, .faces = {}, .c_bias = params_.c_bias};
    if (params_.c_scale > 0) map.c_scale = params_.c_scale;
    std::vector<std::optional<LightView>> views;
    uint64_t texels = 0;
    for (const LightFace& face : faces_) {
      views.push_back(ViewOf(face, resolution));
      if (views.back()) texels += uint64_t{views.back()->width} * views.back()->height;
    }
    if (texels > kMaxWidthTexels) {
      return FieldError(absl::StatusCode::kResourceExhausted, "QUOTA_WIDTH_TEXELS", "resolution",
                        absl::StrCat("found ", resolution, ", at which the light's faces have ",
                                     texels, " texels, need at most ", kMaxWidthTexels));
    }
    for (size_t f = 0; f < faces_.size(); ++f) {
      if (!views[f]) continue;
      auto made = MakeFace(*views[f]);
      if (!made.ok()) return made.status();
      if (faces_.size() > 1) made->window = Intersection(faces_[f].window, views[f]->window);
      map.faces.push_back(*std::move(made));
    }
    return map;
  }

 private:
  // nullopt: nothing is to be seen there.
  std::optional<LightView> ViewOf(LightFace face, uint32_t resolution) const {
    const double finest = kFinest * LongerSide(face.window);
    if (!CenterView(face, boxes_, finest)) return std::nullopt;
    if (faces_.size() > 1) face = WithMargin(face);
    const auto tight = CenterView(face, boxes_, finest);
    return CenterView(face, boxes_, LongerSide(tight->window) / resolution);
  }

  absl::StatusOr<ShadowWidthFace> MakeFace(const LightView& view) {
    std::optional<DepthMap> nearest;
    absl::Status status = source_.Draw({&view, 1}, context_.stop, [&](size_t, DepthMap map) {
      nearest = std::move(map);
      return absl::OkStatus();
    });
    if (!status.ok()) return status;
    const auto layers = tracer_.Trace(*nearest, context_.stop);
    if (!layers.ok()) return layers.status();
    return MakeWidthFace(*nearest, *layers, params_,
                         [this](const BlockedMask& mask) { return Distances(mask); });
  }

  absl::StatusOr<std::vector<float>> Distances(const BlockedMask& mask) const {
    switch (params_.distance) {
      case DistanceMethod::kExact:
        break;
      case DistanceMethod::kSweep:
        return DistanceBySweeps(mask, SweepNeighbours::kFour, context_.arena, context_.stop);
      case DistanceMethod::kGlThree:
        return Steps(mask, StepNeighbours::kThree);
      case DistanceMethod::kGlSix:
        return Steps(mask, StepNeighbours::kSix);
    }
    return DistanceToLit(mask, context_.arena, context_.stop);
  }

  absl::StatusOr<std::vector<float>> Steps(const BlockedMask& mask,
                                           StepNeighbours neighbours) const {
    return context_.gl ? DistanceBySteps(*context_.gl, mask, neighbours, context_.stop)
                       : DistanceByStepsOnCpu(mask, neighbours, context_.arena, context_.stop);
  }

  const ShadowWidthParams& params_;
  const AreaLight light_;
  DepthSource& source_;
  const ShadowLayerTracer tracer_;
  const ComputeContext& context_;
  std::vector<Aabb> boxes_;
  std::vector<LightFace> faces_;
};

ArtifactHeader HeaderFor(const Scene& scene, const ArtifactSpec& spec) {
  const ShadowWidthParams& params = ParamsOf(spec);
  ArtifactHeader header = HeaderOf(scene, spec);
  header.samples_requested = 1;
  header.light_samples = {MiddleOf(*scene.FindLight(spec.light_id))};
  header.parameters = {
      {"distance", std::string(NameOf(params.distance))},
      {"layers", absl::StrCat(params.layers)},
      {"blocker_depth", std::string(NameOf(params.blocker_depth))},
      {"c_scale", params.c_scale > 0 ? FloatText(params.c_scale) : "by the light"},
      {"c_bias", FloatText(params.c_bias)},
  };
  return header;
}

}  // namespace

absl::Status ShadowWidth::Check(const Scene& scene, const ArtifactSpec& spec) const {
  if (const auto status = CheckParams(ParamsOf(spec)); !status.ok()) return status;
  if (const auto status = CheckTarget(spec); !status.ok()) return status;
  if (const auto status = CheckTimeBudget(spec); !status.ok()) return status;
  return CheckOneLight(scene, spec.light_id);
}

bool ShadowWidth::NeedsGl(const ArtifactSpec& spec) const {
  return ParamsOf(spec).source == DepthMethod::kGl || NeedsGlFor(ParamsOf(spec).distance);
}

absl::StatusOr<Artifact> ShadowWidth::Compute(const Scene& scene, const ArtifactSpec& spec,
                                              const ComputeContext& context) const {
  if (const auto status = Check(scene, spec); !status.ok()) return status;
  if (NeedsGlFor(ParamsOf(spec).distance) && context.gl == nullptr && !context.cpu_for_gl) {
    return NoGl("shadow_width.distance", NameOf(ParamsOf(spec).distance), context.gl_error);
  }
  CasterBvhs bvhs = KeptBvhs(context);
  const auto source = MakeDepthSource(ParamsOf(spec).source, scene,
                                      {.bvhs = bvhs,
                                       .arena = context.arena,
                                       .gl = context.gl,
                                       .gl_error = context.gl_error,
                                       .cpu_for_gl = context.cpu_for_gl},
                                      "shadow_width.source");
  if (!source.ok()) return source.status();
  const auto all_surfaces = WithAllSurfaces(scene);
  if (!all_surfaces.ok()) return all_surfaces.status();
  Stopwatch watch(context.now_ms);
  Maker maker(scene, **all_surfaces, spec, **source, bvhs, context);
  ArtifactHeader header = HeaderFor(scene, spec);
  for (const uint32_t resolution :
       MapPasses(ParamsOf(spec).resolution, context.progress != nullptr)) {
    auto map = maker.Make(resolution);
    if (!map.ok()) return Within("shadow_width.", map.status());
    header.parameters["resolution"] = absl::StrCat(resolution);
    header.parameters["source"] = (*source)->drawn_by();
    header.is_final = resolution == ParamsOf(spec).resolution;
    Artifact artifact{.header = header, .payload = *std::move(map)};
    artifact.header.timings_ms["compute"] = watch.ElapsedMs();
    ++header.pass;
    if (header.is_final) return artifact;
    context.progress(std::move(artifact));
  }
  return absl::InternalError("no pass was the last");
}

}  // namespace penumbra
