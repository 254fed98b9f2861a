#include "render/technique/coherent_raytrace/depth_image_tracer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <tuple>

namespace penumbra {
namespace {

// Rays from one point through the images, one after another.
class PointRays {
 public:
  PointRays(std::span<const DepthPyramid> images, const RayAccelerations& accelerations,
            DVec3 origin, bool wants_blockers)
      : accelerations_(accelerations),
        traversal_(accelerations.min_max_clipping, accelerations.connectedness && !wants_blockers) {
    origins_.reserve(images.size());
    for (const DepthPyramid& image : images) origins_.emplace_back(image, origin);
    views_.reserve(images.size());
    order_.resize(images.size());
  }

  float Trace(DVec3 way, double end);

  uint64_t steps() const { return traversal_.steps(); }
  uint64_t images() const { return images_; }

 private:
  // A ray in an image, and what of it the image shows.
  struct RayView {
    ImageRay ray;
    const DepthPyramid* image;
    WayInterval seen;  // in s
    double length;
  };

  void Rank();
  std::optional<double> TraceIn(const RayView& view);
  bool IsOpenInAnother(const RayView& view, double t);

  const RayAccelerations& accelerations_;
  ImageTraversal traversal_;
  uint64_t images_ = 0;
  std::vector<ImageOrigin> origins_;
  std::vector<RayView> views_;       // of the images in their order
  std::vector<uint32_t> order_;      // in which they are asked
  std::vector<WayInterval> open_;    // what may be blocked for all that is known, in t
  std::vector<WayInterval> hidden_;  // of that, what an image does not show, in t
  std::vector<WayInterval> in_s_;
};

float PointRays::Trace(DVec3 way, double end) {
  views_.clear();
  for (const ImageOrigin& origin : origins_) {
    const ImageRay ray(origin, way);
    const WayInterval seen = ray.Clip(ray.ParametersOf({0.0, end}));
    views_.push_back({ray, origin.image, seen, seen.empty() ? 0.0 : ray.Length(seen)});
  }
  Rank();
  open_.assign(1, {0.0, end});
  for (const uint32_t i : order_) {
    if (const auto blocked = TraceIn(views_[i])) return static_cast<float>(*blocked);
    if (accelerations_.clear_miss && hidden_.empty()) return kUnblocked;
    if (accelerations_.occlusion_intervals) std::swap(open_, hidden_);
  }
  return kUnblocked;
}

// Short rays first, those that are not seen last.
void PointRays::Rank() {
  std::iota(order_.begin(), order_.end(), 0u);
  if (!accelerations_.ranking) return;
  std::ranges::sort(order_, [&](uint32_t i, uint32_t k) {
    const RayView& a = views_[i];
    const RayView& b = views_[k];
    return std::tuple(a.seen.empty(), a.length, i) < std::tuple(b.seen.empty(), b.length, k);
  });
}

// Where the ray is blocked; nullopt: nowhere, and hidden_ is known.
std::optional<double> PointRays::TraceIn(const RayView& view) {
  const auto& [ray, image, seen, length] = view;
  ++images_;
  hidden_.clear();
  const auto stands = [&](double s) { return !IsOpenInAnother(view, view.ray.WayAt(s)); };
  for (const WayInterval& t : open_) {
    const WayInterval all = ray.ParametersOf(t);
    const WayInterval part{std::max(all.from, seen.from), std::min(all.to, seen.to)};
    if (all.empty() || part.empty()) {
      if (!image->covers_all()) hidden_.push_back(t);
      continue;
    }
    if (!image->covers_all() && part.from > all.from) {
      hidden_.push_back({t.from, ray.WayAt(part.from)});
    }
    in_s_.clear();
    if (const auto blocked = traversal_.Trace(*image, ray, part, stands, in_s_)) {
      return ray.WayAt(*blocked);
    }
    for (const WayInterval& s : in_s_) hidden_.push_back({ray.WayAt(s.from), ray.WayAt(s.to)});
    if (!image->covers_all() && part.to < all.to) hidden_.push_back({ray.WayAt(part.to), t.to});
  }
  return std::nullopt;
}

bool PointRays::IsOpenInAnother(const RayView& view, double t) {
  return std::ranges::any_of(views_, [&](const RayView& other) {
    if (&other == &view) return false;
    const double s = other.ray.ParameterAt(t);
    return s >= other.seen.from && s <= other.seen.to &&
           traversal_.IsOpenAt(*other.image, other.ray, other.seen, s);
  });
}

}  // namespace

double DepthImageTracer::OffsetOf(const SurfacePoint& point) const {
  if (bias_.metres) return *bias_.metres;
  double offset = 0.0;
  for (const DepthPyramid& image : images_) {
    const LightView& view = image.view();
    const DVec3 q = view.frame.FromWorld(DVec3(point.position));
    const DVec3 n = view.frame.DirectionFromWorld(DVec3(point.normal));
    const DVec3 from_eye = view.from_infinity ? DVec3(-DVec2(view.eye), 1.0) : q - view.eye;
    const double depth = view.from_infinity ? q.z - view.near : from_eye.z;
    if (!(depth > 0)) continue;
    const double cos_angle = glm::dot(n, from_eye) / glm::length(from_eye);
    const double sin_angle = std::sqrt(std::max(0.0, 1 - cos_angle * cos_angle));
    offset = std::max(
        offset, bias_.pixels * PixelWidthAt(view, depth) * (0.5 + std::sqrt(0.5) * sin_angle) +
                    bias_.relative * depth);
  }
  return offset;
}

void DepthImageTracer::Trace(const ShadowRays& rays, std::span<float> blocked_at,
                             TraceCounts& counts) const {
  const double end = rays.at_infinity ? std::numeric_limits<double>::infinity() : kRayEnd;
  size_t i = 0;
  for (const RayFan& fan : rays.fans) {
    const DVec3 origin = DVec3(fan.from.position) + OffsetOf(fan.from) * DVec3(fan.from.normal);
    PointRays traced(images_, accelerations_, origin, rays.wants_blockers);
    for (; i < fan.end; ++i) {
      const DVec3 target(rays.x[i], rays.y[i], rays.z[i]);
      blocked_at[i] = traced.Trace(rays.at_infinity ? target : target - origin, end);
    }
    counts.steps += traced.steps();
    counts.images += traced.images();
  }
  counts.rays += rays.x.size();
}

}  // namespace penumbra
