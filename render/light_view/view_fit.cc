#include "render/light_view/view_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace penumbra {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

constexpr Window kNothing{.min = DVec2(kInfinity), .max = DVec2(-kInfinity)};

// Depths in front of an eye; none where near > far.
struct DepthRange {
  double near = kInfinity;
  double far = -kInfinity;
};

void Add(Window& window, const Window& other) {
  window.min = glm::min(window.min, other.min);
  window.max = glm::max(window.max, other.max);
}

DVec2 Corner(const Window& window, int corner) {
  return DVec2((corner & 1) ? window.max.x : window.min.x,
               (corner & 2) ? window.max.y : window.min.y);
}

void AddDepths(DepthRange& depths, const LightView& view, const Aabb& box) {
  for (int i = 0; i < 8; ++i) {
    const double z =
        view.frame.FromWorld(CornerOf(box, i)).z - (view.from_infinity ? 0.0 : view.eye.z);
    depths.near = std::min(depths.near, z);
    depths.far = std::max(depths.far, z);
  }
}

// At most so much of a window.
Window MiddleOf(Window window, DVec2 most) {
  const DVec2 middle = 0.5 * (window.min + window.max), size = window.size();
  for (int axis = 0; axis < 2; ++axis) {
    if (size[axis] <= most[axis]) continue;
    window.min[axis] = middle[axis] - 0.5 * most[axis];
    window.max[axis] = middle[axis] + 0.5 * most[axis];
  }
  return window;
}

// How many times as wide and high as the face's window a view may be.
constexpr double kMostWindows = 3.0;

// What is seen from the frame's middle at slope w and is D metres deep is seen from `eye` at
//
//   w + (w·eye.z − eye.xy) / D
//
// which is linear in w and in 1/D, so that the corners of what they can be bound it. 1/D ends where
// the window would become wider by its own width; an eye that has come close to all there is may
// see it wider still.
Window SeenFrom(DVec3 eye, const Window& window, const DepthRange& depths) {
  const double furthest = 1.0 / depths.far;
  double nearest = depths.near > 0 ? 1.0 / depths.near : kInfinity;
  DVec2 drift(0.0);
  for (int i = 0; i < 4; ++i) {
    drift = glm::max(drift, glm::abs(Corner(window, i) * eye.z - DVec2(eye)));
  }
  const DVec2 size = window.size();
  for (int axis = 0; axis < 2; ++axis) {
    if (drift[axis] > 0) nearest = std::min(nearest, furthest + size[axis] / drift[axis]);
  }
  if (drift == DVec2(0.0)) return window;
  Window seen = kNothing;
  for (int i = 0; i < 4; ++i) {
    for (const double per_depth : {nearest, furthest}) {
      const DVec2 w = Corner(window, i);
      const DVec2 slope = w + (w * eye.z - DVec2(eye)) * per_depth;
      Add(seen, {.min = slope, .max = slope});
    }
  }
  return MiddleOf(seen, kMostWindows * size);
}

// What of the boxes is in the window, and how far it is.
std::optional<LightView> Fit(LightView view, const Window& limit, std::span<const Aabb> boxes,
                             double pitch) {
  if (!(pitch > 0)) return std::nullopt;
  Window window = kNothing;
  DepthRange depths;
  for (const Aabb& box : boxes) {
    if (box.empty()) continue;
    const Window seen = view.from_infinity ? ShearedWindow(view.frame, DVec2(view.eye), box)
                                           : WindowOf(view.frame, view.eye, 0.0, box, limit);
    if (seen.min.x > seen.max.x || seen.min.y > seen.max.y) continue;
    Add(window, seen);
    AddDepths(depths, view, box);
  }
  if (window.empty()) return std::nullopt;
  const DVec2 pixels = glm::ceil(window.size() / pitch);
  const DVec2 size = glm::min(pixels, double{kMaxViewSide});
  view.width = static_cast<uint32_t>(size.x);
  view.height = static_cast<uint32_t>(size.y);
  view.window = window;
  for (int axis = 0; axis < 2; ++axis) {
    if (size[axis] == pixels[axis]) view.window.max[axis] = window.min[axis] + size[axis] * pitch;
  }
  view.near = view.from_infinity ? depths.near : std::max(depths.near, kNearFraction * depths.far);
  view.far = depths.far;
  return view;
}

}  // namespace

std::optional<LightView> ViewFrom(const LightFace& face, const LightSample& sample,
                                  std::span<const Aabb> boxes, double pitch) {
  LightView view{.frame = face.frame, .from_infinity = face.from_infinity};
  if (face.from_infinity) {
    const DVec3 d = face.frame.DirectionFromWorld(DVec3(sample.point));
    // Rays run along −d; a metre deeper they are further by −d.xy / −d.z.
    if (!(d.z < 0)) return std::nullopt;  // beyond the horizon of the frame
    view.eye = DVec3(-DVec2(d) / d.z, 0.0);
    return Fit(view, face.window, boxes, pitch);
  }
  view.eye = face.frame.FromWorld(DVec3(sample.point));
  DepthRange depths;
  for (const Aabb& box : boxes) {
    if (!box.empty()) AddDepths(depths, view, box);
  }
  if (!(depths.far > 0)) return std::nullopt;
  return Fit(view, SeenFrom(view.eye, face.window, depths), boxes, pitch);
}

std::optional<LightView> CenterView(const LightFace& face, std::span<const Aabb> boxes,
                                    double pitch) {
  const LightView view{.frame = face.frame, .from_infinity = face.from_infinity};
  return Fit(view, face.window, boxes, pitch);
}

std::optional<LightView> PartOf(const LightView& view, const Aabb& box) {
  if (box.empty() || view.empty()) return std::nullopt;
  const Window seen = view.from_infinity ? ShearedWindow(view.frame, DVec2(view.eye), box)
                                         : WindowOf(view.frame, view.eye, 0.0, box, view.window);
  const DVec2 scale = view.pixels_per_slope(), size(view.width, view.height);
  const auto pixel = [&](DVec2 at) { return glm::clamp(at, DVec2(0.0), size); };
  const DVec2 first = pixel(glm::floor((seen.min - view.window.min) * scale) - 1.0);
  const DVec2 end = pixel(glm::ceil((seen.max - view.window.min) * scale) + 1.0);
  if (!(first.x < end.x && first.y < end.y)) return std::nullopt;
  LightView part = view;
  part.window = {view.window.min + first / scale, view.window.min + end / scale};
  part.width = static_cast<uint32_t>(end.x - first.x);
  part.height = static_cast<uint32_t>(end.y - first.y);
  return part;
}

}  // namespace penumbra
