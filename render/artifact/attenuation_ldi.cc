#include "render/artifact/attenuation_ldi.h"

#include <algorithm>
#include <cmath>

#include "render/artifact/light_above_plane.h"
#include "render/artifact/plane_on_image.h"

namespace penumbra {
namespace {

// What a pixel knows of a surface at a nearness.
enum class Sight { kSeen, kHidden, kAbsent };
struct Found {
  Sight sight;
  uint16_t count;
};

Found FindLayer(const LdiFace& face, size_t pixel, double nearness, double tolerance) {
  Found found{.sight = Sight::kAbsent, .count = 0};
  double least = tolerance;
  for (uint32_t i = face.offsets[pixel]; i < face.offsets[pixel + 1]; ++i) {
    const double nearer = NearnessOf(face.view.from_infinity, double{face.depths[i]}) - nearness;
    if (std::abs(nearer) <= least) {
      least = std::abs(nearer);
      found = {.sight = Sight::kSeen, .count = face.counts[i]};
    } else if (nearer > tolerance && found.sight == Sight::kAbsent) {
      found.sight = Sight::kHidden;
    }
  }
  return found;
}

float Fraction(const LdiFace& face, const AttenuationLdi& ldi, const PlaneOnImage& plane) {
  const auto width = static_cast<int>(face.view.width);
  const auto height = static_cast<int>(face.view.height);
  const double tolerance = ldi.tolerance * plane.spread();
  const DVec2 first = glm::floor(plane.at - 0.5);
  double seen = 0, weights = 0;
  for (int k = 0; k < 4; ++k) {
    const int x = static_cast<int>(first.x) + k % 2, y = static_cast<int>(first.y) + k / 2;
    if (x < 0 || y < 0 || x >= width || y >= height) continue;
    const DVec2 center(x + 0.5, y + 0.5), off = glm::abs(center - plane.at);
    const size_t pixel = static_cast<size_t>(y) * face.view.width + static_cast<size_t>(x);
    const Found found = FindLayer(face, pixel, plane.At(center), tolerance);
    if (found.sight == Sight::kAbsent) continue;
    const double weight = (1 - off.x) * (1 - off.y);
    weights += weight;
    seen += weight * found.count;
  }
  return weights > 0 ? static_cast<float>(seen / (weights * ldi.sample_count)) : 1.0f;
}

}  // namespace

float Visibility(const AttenuationLdi& ldi, Vec3 point, Vec3 normal) {
  const float most = LightAbovePlane(ldi.light, point, normal);
  if (!(most > 0)) return 0.0f;
  for (const LdiFace& face : ldi.faces) {
    const auto plane = PlaneOnImage::Find(face.view, DVec3(point), DVec3(normal));
    if (plane) return std::min(most, Fraction(face, ldi, *plane));
  }
  return most;
}

}  // namespace penumbra
