#include "render/technique/coherent_raytrace/reference_images.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/math/parallel_for.h"
#include "render/scene/field_error.h"
#include "render/technique/coherent_raytrace/light_eye.h"

namespace penumbra {
namespace {

constexpr uint32_t kMaxPixels = 8192;

absl::Status Invalid(std::string_view reason, std::string_view field, std::string_view message) {
  return FieldError(absl::StatusCode::kInvalidArgument, reason, field, message);
}

absl::Status Check(const ReferenceImageSettings& settings) {
  if (settings.pixels < 1 || settings.pixels > kMaxPixels) {
    return Invalid("RANGE", "resolution",
                   absl::StrCat("found ", settings.pixels, ", need 1 to ", kMaxPixels));
  }
  const GapBias& gap = settings.gap;
  for (const double bias : {gap.metres.value_or(0), gap.relative.value_or(0), gap.pixels}) {
    if (!(bias >= 0) || std::isinf(bias)) {
      return Invalid("RANGE", "gap_bias", absl::StrCat("found ", bias, ", need a number >= 0"));
    }
  }
  for (size_t i = 0; i < settings.places.size(); ++i) {
    if (IsFinite(settings.places[i])) continue;
    return Invalid("NON_FINITE", absl::StrCat("places[", i, "]"), "need finite numbers");
  }
  return absl::OkStatus();
}

// What an image takes, and its depth map, which is gone when it is made.
size_t BytesOf(const LightView& view) {
  const double pixels = static_cast<double>(view.width) * view.height;
  return static_cast<size_t>(pixels * (DepthPyramid::kBytesPerPixel + sizeof(float)));
}

absl::Status CheckBytes(const std::vector<EyeView>& views, const ReferenceImageSettings& settings) {
  size_t bytes = 0;
  for (const EyeView& eye : views) bytes += BytesOf(eye.view);
  if (bytes <= settings.max_bytes) return absl::OkStatus();
  return FieldError(
      absl::StatusCode::kResourceExhausted, "QUOTA_IMAGE_BYTES", "resolution",
      absl::StrCat("found ", settings.pixels, ", with which ", views.size(), " images take ", bytes,
                   " bytes, need at most ", settings.max_bytes));
}

}  // namespace

absl::StatusOr<std::vector<DepthPyramid>> DrawReferenceImages(
    const AreaLight& light, const Scene& scene, const ReferenceImageSettings& settings,
    DepthSource& source, tbb::task_arena& arena, const std::stop_token& stop) {
  if (absl::Status status = Check(settings); !status.ok()) return status;
  std::vector<EyeView> eyes;
  for (const Vec3& place : settings.places.empty() ? LightVertices(light) : settings.places) {
    std::ranges::move(ViewsFrom(light, scene, place, settings.pixels), std::back_inserter(eyes));
  }
  if (absl::Status status = CheckBytes(eyes, settings); !status.ok()) return status;
  std::vector<LightView> views;
  for (const EyeView& eye : eyes) views.push_back(eye.view);
  std::vector<DepthMap> maps;
  const auto take = [&](size_t, DepthMap map) {
    maps.push_back(std::move(map));
    return absl::OkStatus();
  };
  if (absl::Status status = source.Draw(views, stop, take); !status.ok()) return status;
  std::vector<std::optional<DepthPyramid>> images(maps.size());
  RunIn(arena, [&] {
    ParallelFor(maps.size(), [&](size_t i) {
      if (stop.stop_requested()) return;
      images[i].emplace(std::exchange(maps[i], {}), settings.gap, eyes[i].covers_all);
    });
  });
  if (stop.stop_requested()) return absl::CancelledError("stopped");
  std::vector<DepthPyramid> made;
  for (std::optional<DepthPyramid>& image : images) made.push_back(*std::move(image));
  return made;
}

}  // namespace penumbra
