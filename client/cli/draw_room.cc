#include "client/cli/draw_room.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "absl/strings/str_format.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

// Maps of so much fewer texels along a side tell how large the others are, but no smaller ones.
constexpr uint32_t kCoarseness = 8, kLeastSide = 64;
// What a texel of a layer takes, its depth and its width, and a traced pixel.
constexpr double kTexelBytes = 8, kPixelBytes = 4;
// What is told so may be off by this part.
constexpr double kDoubt = 0.02;
// Faces of a light at most, and their texels, of which the part is to be seen from others as well.
constexpr double kMostFaces = 6, kMostSide = 1.25, kMostLayers = 2;

double BytesOf(const ShadowWidthMap& map) {
  double texels = 0;
  for (const ShadowWidthFace& face : map.faces) {
    texels += static_cast<double>(face.near.widths.size()) * (face.far ? 2 : 1);
  }
  return kTexelBytes * texels;
}

double PixelBytes(const ArtifactSpec& spec) {
  const auto* picture = spec.points ? std::get_if<PicturePixels>(&*spec.points) : nullptr;
  if (picture == nullptr) return 0;
  return kPixelBytes * picture->part().width * picture->part().height;
}

absl::Status TooLarge(uint32_t resolution, size_t lights, double bytes, double for_widths,
                      const DrawRoom& room) {
  // A step below what just fits, as a round number.
  const double side = (1 - kDoubt) * resolution * std::sqrt(std::max(for_widths, 0.0) / bytes);
  const auto fits = std::max(1u, static_cast<uint32_t>(side) / 16 * 16);
  return FieldError(
      absl::StatusCode::kResourceExhausted, "QUOTA_DRAW_BYTES", "--set resolution",
      absl::StrFormat("found %d, at which the shadow%s of %d light%s take%s %.0f MB, need at most "
                      "%.0f MB to draw with %s: a resolution of %d or less, or fewer lights by "
                      "--light",
                      resolution, lights == 1 ? "" : "s", lights, lights == 1 ? "" : "s",
                      lights == 1 ? "s" : "", 1e-6 * bytes, 1e-6 * for_widths, room.device, fits));
}

}  // namespace

absl::Status CheckWidthsFit(const std::vector<PlannedShadow>& wanted, const DrawRoom& room,
                            const ComputePlanned& compute) {
  double left = static_cast<double>(room.bytes);
  std::vector<PlannedShadow> small;
  uint32_t resolution = 0;
  for (const PlannedShadow& shadow : wanted) {
    left -= PixelBytes(shadow.spec);
    if (!std::holds_alternative<ShadowWidthParams>(shadow.spec.params)) continue;
    small.push_back(shadow);
    auto& params = std::get<ShadowWidthParams>(small.back().spec.params);
    resolution = params.resolution;
    params.resolution = std::max(resolution / kCoarseness, std::min(resolution, kLeastSide));
  }
  const double most_texels = kMostFaces * kMostLayers * std::pow(kMostSide * resolution, 2.0);
  if (kTexelBytes * most_texels * static_cast<double>(small.size()) <= left) {
    return absl::OkStatus();
  }
  double bytes = 0;
  for (const PlannedShadow& shadow : small) {
    const auto artifact = compute(shadow);
    if (!artifact.ok()) return artifact.status();
    const auto* map = std::get_if<ShadowWidthMap>(&(*artifact)->payload);
    if (map == nullptr) continue;
    const double side = std::get<ShadowWidthParams>(shadow.spec.params).resolution;
    bytes += BytesOf(*map) * std::pow(resolution / side, 2.0);
  }
  if (bytes <= (1 + kDoubt) * left) return absl::OkStatus();
  return TooLarge(resolution, small.size(), bytes, left, room);
}

}  // namespace penumbra
