#include "render/technique/layered_attenuation/ldi_passes.h"

#include <algorithm>
#include <cmath>
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

// What a key view takes to be drawn into, beside its map.
constexpr size_t kCanvasBytes = sizeof(float) + sizeof(uint32_t);

// The middle of what the face sees.
Vec3 TargetOf(const LightFace& face) {
  if (face.from_infinity) return Vec3(face.frame.origin);
  const DVec2 middle = 0.5 * (face.window.min + face.window.max);
  return Vec3(face.frame.ToWorld(DVec3(middle, 1.0)));
}

size_t PixelsOf(const LightView& view) { return size_t{view.width} * view.height; }

// With a layer at each pixel.
size_t BytesOfLayers(const LightView& center) {
  return PixelsOf(center) * (sizeof(uint32_t) + LayerBand::kBytesPerLayer);
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
  passes->boxes_ = scene.casters().bounds();
  passes->has_casters_ = !passes->boxes_.empty();
  for (const SeenSurface& surface : passes->seen_) {
    const std::vector<Aabb>& more = surface.scene->casters().bounds();
    passes->boxes_.insert(passes->boxes_.end(), more.begin(), more.end());
  }
  Aabb bounds;
  for (const Aabb& box : passes->boxes_) bounds.Add(box);
  for (const LightFace& face : FacesOf(light, bounds)) {
    if (const auto status = passes->AddFace(face); !status.ok()) return status;
  }
  const auto status = CheckLdiBytes(passes->LeastBytes(), options.limits.max_bytes);
  if (!status.ok()) return status;
  for (Face& face : passes->faces_) passes->MakeBuilders(face);
  return passes;
}

absl::Status LdiPasses::AddFace(const LightFace& face) {
  const auto tight = CenterView(face, boxes_, kFinest * LongerSide(face.window));
  if (!tight) return absl::OkStatus();
  const double pitch = LongerSide(tight->window) / options_.resolution;
  const auto center = CenterView(face, boxes_, pitch);
  if (!center) return absl::OkStatus();
  Face added{.face = face,
             .samples = SampleLight(light_, options_.samples, options_.seed, TargetOf(face)),
             .keys = {*center}};
  const auto rim = ViewsOf(added, KeySamples(light_, face));
  if (!rim.ok()) return rim.status();
  added.keys.insert(added.keys.end(), rim->views.begin(), rim->views.end());
  faces_.push_back(std::move(added));
  return absl::OkStatus();
}

void LdiPasses::MakeBuilders(Face& face) {
  const auto make = [&] {
    return std::make_unique<LdiBuilder>(face.center(), 0.5f * tolerance_, options_.limits, use_);
  };
  face.builder = make();
  if (options_.key_views && !seen_.empty()) face.casters = make();
}

size_t LdiPasses::LeastBytes() const {
  size_t layers = 0, map_pixels = 0;
  for (const Face& face : faces_) {
    layers += BytesOfLayers(face.center());
    for (const LightView& view : face.keys) map_pixels = std::max(map_pixels, PixelsOf(view));
  }
  const size_t per_pixel = LdiBuilder::kBytesPerPixel + (options_.key_views ? kCanvasBytes : 0);
  return layers + std::min(kPortion, sample_count_) * map_pixels * per_pixel;
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
    const auto some = views.subspan(first, std::min<size_t>(kPortion, views.size() - first));
    size_t bytes = 0;
    for (const LightView& view : some) bytes += PixelsOf(view) * kCanvasBytes;
    const LdiLease canvases(use_, bytes);
    std::vector<DepthMap> maps(some.size());
    RunIn(arena_, [&] {
      ParallelFor(maps.size(), [&](size_t m) {
        if (!stop.stop_requested()) maps[m] = keys.MapFor(some[m]);
      });
    });
    if (stop.stop_requested()) return absl::CancelledError("stopped");
    const auto status = face.builder->InsertKnown(std::move(maps), arena_, stop);
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::StatusOr<LdiPasses::SampleViews> LdiPasses::ViewsOf(
    const Face& face, std::span<const LightSample> samples) const {
  SampleViews found;
  const double pitch = 1.0 / face.center().pixels_per_slope().x;
  for (size_t i = 0; i < samples.size(); ++i) {
    const auto view = ViewFrom(face.face, samples[i], boxes_, pitch);
    if (!view) continue;
    // Larger pixels than the middle's would be looked up elsewhere.
    const auto side = static_cast<int64_t>(std::lround(LongerSide(view->window) / pitch));
    if (side > kMaxViewSide) {
      return FieldError(
          absl::StatusCode::kResourceExhausted, "VIEW_SIZE", "resolution",
          absl::StrCat("found ", options_.resolution, ", at which a light sample sees ", side,
                       " pixels a side, need at most ", kMaxViewSide));
    }
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
  for (const SeenSurface& surface : seen_) {
    Aabb box;
    for (const Aabb& part : surface.scene->casters().bounds()) box.Add(part);
    std::vector<LightView> parts;
    for (const LightView& view : face.keys) {
      if (const auto part = PartOf(view, box)) parts.push_back(*part);
    }
    const auto status = AddSurfaces(*surface.source, parts, *face.builder, stop);
    if (!status.ok()) return status;
  }
  const auto views = std::span(face.keys).first(options_.key_views ? face.keys.size() : 1);
  const auto status = AddSurfaces(source_, views, *face.builder, stop);
  return status.ok() && face.casters ? AddSurfaces(source_, views, *face.casters, stop) : status;
}

absl::Status LdiPasses::Advance(Face& face, uint32_t upto, const std::stop_token& stop) {
  const auto samples = std::span(face.samples).subspan(done_, upto - done_);
  // As wide as what is looked up in them, which may lie deeper than all that casts.
  const auto seen = ViewsOf(face, samples.first(has_casters_ ? samples.size() : 0));
  if (!seen.ok()) return seen.status();
  if (done_ == 0) {
    if (const auto status = Start(face, stop); !status.ok()) return status;
  }
  for (size_t i = seen->views.size(); i < samples.size(); ++i) face.builder->InsertNothing();
  if (seen->views.empty()) return absl::OkStatus();
  return options_.key_views ? Synthesize(seen->views, face, stop)
                            : Draw(*seen, *face.builder, stop);
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
