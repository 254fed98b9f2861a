#include "render/technique/layered_attenuation/key_views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <variant>

#include "render/artifact/attenuation_ldi.h"
#include "render/artifact/plane_on_image.h"
#include "render/math/basis.h"

namespace penumbra {
namespace {

// The ends of two diameters.
std::array<DVec3, 4> Rim(DVec3 center, DVec3 axis, double radius) {
  const Basis basis = BasisAround(axis);
  return {center - radius * basis.s, center + radius * basis.s, center - radius * basis.t,
          center + radius * basis.t};
}

struct Keys {
  const LightFace& face;

  static std::vector<LightSample> Points(const std::array<DVec3, 4>& points, bool at_infinity) {
    std::vector<LightSample> samples;
    for (const DVec3& p : points) {
      samples.push_back({.point = Vec3(p), .at_infinity = at_infinity, .weight = 0.25f});
    }
    return samples;
  }

  std::vector<LightSample> operator()(const RectangleLight& light) const {
    const DVec3 corner(light.corner), u(light.edge_u), v(light.edge_v);
    return Points({corner, corner + u + v, corner + u, corner + v}, false);
  }
  std::vector<LightSample> operator()(const DiskLight& light) const {
    return Points(Rim(DVec3(light.center), DVec3(light.normal), light.radius), false);
  }
  std::vector<LightSample> operator()(const SphereLight& light) const {
    return Points(Rim(DVec3(light.center), face.frame.axes.n, light.radius), false);
  }
  std::vector<LightSample> operator()(const PointLight&) const { return {}; }
  std::vector<LightSample> operator()(const SpotLight&) const { return {}; }
  std::vector<LightSample> operator()(const DistantLight& light) const {
    if (light.angular_diameter == 0) return {};
    const DVec3 axis = glm::normalize(DVec3(light.to_light));
    auto directions = Rim(axis, axis, std::tan(0.5 * double{light.angular_diameter}));
    for (DVec3& direction : directions) direction = glm::normalize(direction);
    return Points(directions, true);
  }
};

constexpr uint32_t kNoPixel = 0xffff'ffff;

// A view as it is drawn into, with the middle view's pixel that each of its pixels is from.
struct Canvas {
  uint32_t width, height;
  uint32_t center_width;
  float steepest;  // what nearness may change by within a pixel, of nearness 1
  bool from_infinity;
  std::vector<float> nearness;
  std::vector<uint32_t> sources;

  void Draw(const ImagePlane& plane, Vec2 at, uint32_t source) {
    const bool is_inside = at.x >= 0 && at.y >= 0 && at.x < static_cast<float>(width) &&
                           at.y < static_cast<float>(height);
    if (!is_inside) return;
    const Vec2 pixel = PixelAt(at);
    const size_t p = static_cast<size_t>(pixel.y) * width + static_cast<size_t>(pixel.x);
    const float drawn = plane.nearness + glm::dot(plane.gradient, pixel + 0.5f - at);
    if (!(drawn > nearness[p])) return;
    nearness[p] = drawn;
    sources[p] = source;
  }

  bool AreNeighbours(uint32_t a, uint32_t b) const {
    if (a == kNoPixel || b == kNoPixel) return false;
    const auto apart = [](uint32_t i, uint32_t j) { return i < j ? j - i : i - j; };
    return apart(a % center_width, b % center_width) <= 1 &&
           apart(a / center_width, b / center_width) <= 1;
  }

  // What is seen at p once the gap that it may be between the pixels `step` before and after it is
  // closed: what they show is one surface, next to each other in the middle view.
  float Closed(size_t p, size_t step) const {
    const float a = nearness[p - step], b = nearness[p + step], here = nearness[p];
    if (!(here < std::min(a, b))) return here;
    const float middle = 0.5f * (a + b);
    const bool is_one = std::abs(a - b) <= 2 * steepest * (from_infinity ? 1.0f : middle);
    return is_one && AreNeighbours(sources[p - step], sources[p + step]) ? middle : here;
  }

  DepthMap Finish(const LightView& view) const {
    DepthMap map{.view = view, .depths = std::vector<float>(nearness.size())};
    for (uint32_t y = 0; y < height; ++y) {
      for (uint32_t x = 0; x < width; ++x) {
        const size_t p = size_t{y} * width + x;
        float seen = nearness[p];
        if (x > 0 && x + 1 < width) seen = std::max(seen, Closed(p, 1));
        if (y > 0 && y + 1 < height) seen = std::max(seen, Closed(p, width));
        map.depths[p] = from_infinity ? -seen : 1 / seen;
      }
    }
    return map;
  }
};

}  // namespace

std::vector<LightSample> KeySamples(const AreaLight& light, const LightFace& face) {
  return std::visit(Keys{face}, light.shape);
}

DepthMap KeyViews::MapFor(const LightView& view) const {
  const LightView& center = layers_.center();
  const ViewWarp warp(center, view);
  const size_t pixels = size_t{view.width} * view.height;
  const float nothing = NearnessOf(view.from_infinity, kNoDepth);
  Canvas canvas{.width = view.width,
                .height = view.height,
                .center_width = center.width,
                .steepest = static_cast<float>(kMaxSteepness) * layers_.pixel_width(),
                .from_infinity = view.from_infinity,
                .nearness = std::vector<float>(pixels, nothing),
                .sources = std::vector<uint32_t>(pixels, kNoPixel)};
  for (const LayerBand& band : layers_.bands()) {
    for (size_t k = 0; k < band.size(); ++k) {
      ImagePlane plane = band.Plane(k);
      const Vec2 source = plane.at + warp.center_origin;
      const float behind = 1 - warp.ahead * plane.nearness;
      if (!(behind > 0)) continue;
      const Vec2 at = warp.ToView(plane.at, plane.nearness) + warp.view_origin;
      plane.nearness /= behind;
      canvas.Draw(plane, at,
                  static_cast<uint32_t>(source.y) * center.width + static_cast<uint32_t>(source.x));
    }
  }
  return canvas.Finish(view);
}

}  // namespace penumbra
