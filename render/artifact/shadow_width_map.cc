#include "render/artifact/shadow_width_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "render/artifact/light_above_plane.h"
#include "render/artifact/light_width.h"
#include "render/artifact/plane_on_image.h"

namespace penumbra {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// What one texel of one layer says of a surface.
struct Texel {
  double width = 0;     // 0: it is not in shadow there
  double nearness = 0;  // of the blocker, where it is
};

// The four texels around a point, at (0, 0), (1, 0), (0, 1) and (1, 1).
struct Texels {
  std::array<double, 4> weights{};
  std::array<Texel, 4> near, far;
  DVec2 t{0.0};  // of the point, from the first
};

// The same between them.
struct Shade {
  double width = 0;
  double nearness = 0;
  DVec2 direction{0.0};  // in which the width grows, of length 1, or 0
};

// Texel i of the layer; what is in shadow is deeper than `nearness` tells.
Texel InLayer(const ShadowWidthLayer& layer, bool from_infinity, size_t i, double nearness) {
  const double blocker = NearnessOf(from_infinity, double{layer.depths[i]});
  if (!(layer.widths[i] > 0) || !(nearness < blocker)) return {};
  return {.width = layer.widths[i], .nearness = blocker};
}

Texels TexelsAround(const ShadowWidthFace& face, const PlaneOnImage& plane) {
  const LightView& view = face.view;
  const DVec2 first = glm::floor(plane.at - 0.5);
  Texels texels{.t = plane.at - 0.5 - first};
  for (int k = 0; k < 4; ++k) {
    const int x = static_cast<int>(first.x) + k % 2, y = static_cast<int>(first.y) + k / 2;
    if (x < 0 || y < 0 || x >= static_cast<int>(view.width) || y >= static_cast<int>(view.height)) {
      continue;
    }
    const DVec2 center(x + 0.5, y + 0.5), off = glm::abs(center - plane.at);
    const size_t i = static_cast<size_t>(y) * view.width + static_cast<size_t>(x);
    const double nearness = plane.At(center) + plane.spread();
    texels.weights[k] = (1 - off.x) * (1 - off.y);
    texels.near[k] = InLayer(face.near, view.from_infinity, i, nearness);
    if (face.far) texels.far[k] = InLayer(*face.far, view.from_infinity, i, nearness);
  }
  return texels;
}

// A texel that has one blocker goes with the far ones where it is nearer to these.
void Group(Texels& texels) {
  double near = 0, far = 0, count = 0;
  for (int k = 0; k < 4; ++k) {
    if (!(texels.far[k].width > 0)) continue;
    near += texels.near[k].nearness, far += texels.far[k].nearness, ++count;
  }
  for (int k = 0; count > 0 && k < 4; ++k) {
    const bool has_one = texels.near[k].width > 0 && !(texels.far[k].width > 0);
    if (has_one && 2 * count * texels.near[k].nearness < near + far) {
      texels.far[k] = std::exchange(texels.near[k], Texel{});
    }
  }
}

DVec2 DirectionOf(const std::array<Texel, 4>& texels, DVec2 t) {
  const auto width = [&](int k) { return std::min(texels[k].width, 1e30); };
  const DVec2 growth((width(1) - width(0)) * (1 - t.y) + (width(3) - width(2)) * t.y,
                     (width(2) - width(0)) * (1 - t.x) + (width(3) - width(1)) * t.x);
  const double length = glm::length(growth);
  return length > 0 ? growth / length : DVec2(0.0);
}

Shade ShadeOf(const std::array<Texel, 4>& texels, const std::array<double, 4>& all, DVec2 t) {
  Shade shade;
  double weights = 0, shadowed = 0;
  for (int k = 0; k < 4; ++k) {
    weights += all[k];
    if (!(texels[k].width > 0) || !(all[k] > 0)) continue;
    shadowed += all[k];
    shade.width += all[k] * texels[k].width;
    shade.nearness += all[k] * texels[k].nearness;
  }
  if (!(shadowed > 0)) return {};
  shade.width /= weights;
  shade.nearness /= shadowed;
  shade.direction = DirectionOf(texels, t);
  return shade;
}

// With a texel to spare, so that rounding leaves no gap between faces.
bool TellsOf(const ShadowWidthFace& face, DVec2 at) {
  const DVec2 scale = face.view.pixels_per_slope();
  const DVec2 first = (face.window.min - face.view.window.min) * scale - 1.0;
  const DVec2 end = (face.window.max - face.view.window.min) * scale + 1.0;
  return glm::all(glm::greaterThanEqual(at, first)) && glm::all(glm::lessThanEqual(at, end));
}

// Behind one layer's blockers.
double ShareBehind(const Shade& shade, const ShadowWidthFace& face, const ShadowWidthMap& map,
                   const PlaneOnImage& plane) {
  if (!(shade.width > 0)) return 1;
  const LightView& view = face.view;
  const double blocker = DepthAt(view.from_infinity, shade.nearness);
  const double depth = DepthAt(view.from_infinity, plane.nearness);
  const double per_window = view.from_infinity ? 1 : depth;  // metres at the point
  const double texel = per_window / view.pixels_per_slope().x;
  const double shadow_depth = depth - blocker;
  double c_scale = shadow_depth / texel;
  if (map.c_scale) {
    c_scale = std::min(c_scale, double{*map.c_scale});
  } else {
    const DVec2 at = view.window.min + plane.at / view.pixels_per_slope();
    const double width = LightWidth(map.light, view).Along(at, shade.direction);
    if (width > 0) c_scale = std::min(c_scale, (view.from_infinity ? 1 : blocker) / width);
  }
  return Attenuation(shadow_depth, per_window * shade.width, c_scale, map.c_bias);
}

double Share(const ShadowWidthFace& face, const ShadowWidthMap& map, const PlaneOnImage& plane) {
  Texels texels = TexelsAround(face, plane);
  if (!face.far) {
    return ShareBehind(ShadeOf(texels.near, texels.weights, texels.t), face, map, plane);
  }
  Group(texels);
  return std::min(ShareBehind(ShadeOf(texels.near, texels.weights, texels.t), face, map, plane),
                  ShareBehind(ShadeOf(texels.far, texels.weights, texels.t), face, map, plane));
}

}  // namespace

double Attenuation(double shadow_depth, double shadow_width, double c_scale, double c_bias) {
  if (!(shadow_depth > 0) || !(shadow_width > 0)) return 1;
  if (shadow_width == kInfinity || c_scale == kInfinity) return 0;
  return std::clamp(1 + c_bias - c_scale * shadow_width / shadow_depth, 0.0, 1.0);
}

float Visibility(const ShadowWidthMap& map, Vec3 point, Vec3 normal) {
  const float most = LightAbovePlane(map.light, point, normal);
  if (!(most > 0)) return 0.0f;
  for (const ShadowWidthFace& face : map.faces) {
    const auto plane = PlaneOnImage::Find(face.view, DVec3(point), DVec3(normal));
    if (plane && TellsOf(face, plane->at))
      return std::min(most, static_cast<float>(Share(face, map, *plane)));
  }
  return most;
}

}  // namespace penumbra
