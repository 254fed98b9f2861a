#include "render/technique/layered_attenuation/ldi_passes.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/light_view/view_fit.h"
#include "render/math/parallel_for.h"
#include "render/scene/caster_tree.h"
#include "render/scene/field_error.h"
#include "render/scene/scene_limits.h"
#include "render/technique/layered_attenuation/key_views.h"

namespace penumbra {
namespace {

// Of the longest side of a face: fine enough to tell how large it is, and within what a view holds.
constexpr double kFinest = 2.0 / kMaxViewSide;

absl::Status RangeError(std::string_view field, const std::string& found, const std::string& need) {
  return FieldError(absl::StatusCode::kInvalidArgument, "RANGE", field,
                    absl::StrCat("found ", found, ", need ", need));
}

double LongerSide(const Window& window) { return std::max(window.size().x, window.size().y); }

// The middle of what the face sees.
Vec3 TargetOf(const LightFace& face) {
  if (face.from_infinity) return Vec3(face.frame.origin);
  const DVec2 middle = 0.5 * (face.window.min + face.window.max);
  return Vec3(face.frame.ToWorld(DVec3(middle, 1.0)));
}

std::vector<Aabb> CasterBoxes(const Scene& scene) {
  std::vector<Aabb> boxes;
  for (const auto& [id, instance] : scene.instances()) {
    if (instance->casts && instance->mesh->triangle_count() > 0) {
      boxes.push_back(CasterBounds(*instance));
    }
  }
  return boxes;
}

// What an LDI of as many pixels takes at least, before anything is known of it.
size_t BytesOf(const LightView& view) {
  const size_t pixels = size_t{view.width} * view.height;
  return pixels * (sizeof(uint32_t) + 26 + LdiPasses::kPortion * (sizeof(float) + 1));
}

}  // namespace

absl::Status CheckLdiOptions(const LdiOptions& options) {
  const uint32_t most = SceneLimits{}.max_light_samples;
  if (options.samples < 1 || options.samples > most) {
    return RangeError("samples", absl::StrCat(options.samples), absl::StrCat("1 to ", most));
  }
  if (options.resolution < kMinLdiResolution || options.resolution > kMaxLdiResolution) {
    return RangeError("resolution", absl::StrCat(options.resolution),
                      absl::StrCat(kMinLdiResolution, " to ", kMaxLdiResolution));
  }
  const float tolerance = options.tolerance.value_or(kAutomaticLdiTolerance);
  if (!(tolerance > 0 && tolerance <= kMaxLdiTolerance)) {
    return RangeError("tolerance", absl::StrCat(tolerance),
                      absl::StrCat("more than 0 and at most ", kMaxLdiTolerance));
  }
  return absl::OkStatus();
}

LdiPasses::LdiPasses(const AreaLight& light, const LdiOptions& options, DepthSource& source,
                     tbb::task_arena& arena, std::vector<SeenSurface> seen)
    : light_(light),
      options_(options),
      source_(source),
      seen_(std::move(seen)),
      arena_(arena),
      tolerance_(options.tolerance.value_or(kAutomaticLdiTolerance)),
      sample_count_(EffectiveSampleCount(light, options.samples)) {}

absl::StatusOr<std::unique_ptr<LdiPasses>> LdiPasses::Create(
    const Scene& scene, const AreaLight& light, const LdiOptions& options, DepthSource& source,
    tbb::task_arena& arena, std::vector<SeenSurface> seen) {
  if (const auto status = CheckLdiOptions(options); !status.ok()) return status;
  std::unique_ptr<LdiPasses> passes(new LdiPasses(light, options, source, arena, std::move(seen)));
  passes->boxes_ = CasterBoxes(scene);
  passes->has_casters_ = !passes->boxes_.empty();
  for (const SeenSurface& surface : passes->seen_) {
    const std::vector<Aabb> more = CasterBoxes(*surface.scene);
    passes->boxes_.insert(passes->boxes_.end(), more.begin(), more.end());
  }
  Aabb bounds;
  for (const Aabb& box : passes->boxes_) bounds.Add(box);
  for (const LightFace& face : FacesOf(light, bounds)) {
    if (const auto status = passes->AddFace(face); !status.ok()) return status;
  }
  return passes;
}

absl::Status LdiPasses::AddFace(const LightFace& face) {
  const auto tight = CenterView(face, boxes_, kFinest * LongerSide(face.window));
  if (!tight) return absl::OkStatus();
  const double pitch = LongerSide(tight->window) / options_.resolution;
  const auto center = CenterView(face, boxes_, pitch);
  if (!center) return absl::OkStatus();
  const size_t bytes = BytesOf(*center);
  if (bytes > options_.limits.max_bytes) {
    return FieldError(absl::StatusCode::kResourceExhausted, "QUOTA_LDI_BYTES", "resolution",
                      absl::StrCat("found ", options_.resolution, ", which takes ", bytes,
                                   " bytes, need at most ", options_.limits.max_bytes));
  }
  const auto make_builder = [&] {
    return std::make_unique<LdiBuilder>(*center, 0.5f * tolerance_, options_.limits, use_);
  };
  faces_.push_back({.face = face,
                    .samples = SampleLight(light_, options_.samples, options_.seed, TargetOf(face)),
                    .builder = make_builder(),
                    .casters = options_.key_views && !seen_.empty() ? make_builder() : nullptr});
  return absl::OkStatus();
}

absl::Status LdiPasses::Draw(const SampleViews& samples, LdiBuilder& builder,
                             const std::stop_token& stop) {
  const auto portion = [&](size_t i) { return samples.indices[i] / kPortion; };
  std::vector<DepthMap> maps;
  return source_.Draw(samples.views, stop, [&](size_t i, DepthMap map) {
    maps.push_back(std::move(map));
    if (i + 1 < samples.views.size() && portion(i + 1) == portion(i)) return absl::OkStatus();
    return builder.Insert(std::exchange(maps, {}), arena_, stop);
  });
}

absl::Status LdiPasses::Synthesize(std::span<const LightView> views, Face& face,
                                   const std::stop_token& stop) {
  const KeyViews keys(face.casters ? *face.casters : *face.builder);
  for (size_t first = 0; first < views.size(); first += kPortion) {
    std::vector<DepthMap> maps(std::min<size_t>(kPortion, views.size() - first));
    RunIn(arena_, [&] {
      ParallelFor(maps.size(), [&](size_t m) {
        if (!stop.stop_requested()) maps[m] = keys.MapFor(views[first + m]);
      });
    });
    if (stop.stop_requested()) return absl::CancelledError("stopped");
    const auto status = face.builder->InsertKnown(std::move(maps), arena_, stop);
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

LdiPasses::SampleViews LdiPasses::ViewsOf(const Face& face,
                                          std::span<const LightSample> samples) const {
  SampleViews found;
  const double pitch = 1.0 / face.builder->center().pixels_per_slope().x;
  for (size_t i = 0; i < samples.size(); ++i) {
    const auto view = ViewFrom(face.face, samples[i], boxes_, pitch);
    if (!view) continue;
    found.views.push_back(*view);
    found.indices.push_back(i);
  }
  return found;
}

absl::Status LdiPasses::AddSurfaces(DepthSource& source, std::span<const LightView> views,
                                    LdiBuilder& builder, const std::stop_token& stop) {
  return source.Draw(views, stop, [&](size_t, DepthMap map) {
    return builder.AddSurfaces(std::move(map), arena_, stop);
  });
}

absl::Status LdiPasses::Start(Face& face, const std::stop_token& stop) {
  const LightView center = face.builder->center();
  std::vector<LightView> views = ViewsOf(face, KeySamples(light_, face.face)).views;
  views.insert(views.begin(), center);
  for (const SeenSurface& surface : seen_) {
    const auto status = AddSurfaces(*surface.source, views, *face.builder, stop);
    if (!status.ok()) return status;
  }
  if (!options_.key_views) views = {center};
  const auto status = AddSurfaces(source_, views, *face.builder, stop);
  return status.ok() && face.casters ? AddSurfaces(source_, views, *face.casters, stop) : status;
}

absl::Status LdiPasses::Advance(Face& face, uint32_t upto, const std::stop_token& stop) {
  if (done_ == 0) {
    if (const auto status = Start(face, stop); !status.ok()) return status;
  }
  const auto samples = std::span(face.samples).subspan(done_, upto - done_);
  // As wide as what is looked up in them, which may lie deeper than all that casts.
  const SampleViews seen = has_casters_ ? ViewsOf(face, samples) : SampleViews{};
  for (size_t i = seen.views.size(); i < samples.size(); ++i) face.builder->InsertNothing();
  if (seen.views.empty()) return absl::OkStatus();
  return options_.key_views ? Synthesize(seen.views, face, stop) : Draw(seen, *face.builder, stop);
}

absl::Status LdiPasses::Advance(uint32_t upto, const std::stop_token& stop) {
  const uint32_t portions = upto / kPortion + (upto % kPortion > 0);
  upto = portions > sample_count_ / kPortion ? sample_count_ : portions * kPortion;
  if (upto <= done_) return absl::OkStatus();
  for (Face& face : faces_) {
    if (stop.stop_requested()) return absl::CancelledError("stopped");
    if (const auto status = Advance(face, upto, stop); !status.ok()) return status;
  }
  done_ = upto;
  return absl::OkStatus();
}

std::vector<LightSample> LdiPasses::samples_done() const {
  std::vector<LightSample> samples;
  for (size_t f = 0; f < faces_.size(); ++f) {
    if (f > 0 && faces_[f].samples == faces_[0].samples) continue;
    samples.insert(samples.end(), faces_[f].samples.begin(), faces_[f].samples.begin() + done_);
  }
  for (LightSample& sample : samples) sample.weight = 1.0f / static_cast<float>(samples.size());
  return samples;
}

float LdiPasses::tolerance() const {
  float most = tolerance_;
  for (const Face& face : faces_) most = std::max(most, 2 * face.builder->tolerance());
  return most;
}

AttenuationLdi LdiPasses::Finish() const {
  AttenuationLdi ldi{.light = light_, .faces = {}, .sample_count = done_, .tolerance = tolerance()};
  for (const Face& face : faces_) ldi.faces.push_back(face.builder->Finish());
  return ldi;
}

}  // namespace penumbra
