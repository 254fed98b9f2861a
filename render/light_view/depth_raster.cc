#include "render/light_view/depth_raster.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "render/light_view/depth_source.h"
#include "render/scene/triangle_clusters.h"

namespace penumbra {
namespace {

// The part of the far depth nearer than which 1/z is too large to be blended in single precision
// with that of what is far.
constexpr double kCarefulFraction = 0x1p-5;

// Pixels around the image within which what single precision places elsewhere may still be seen.
constexpr double kMarginPixels = 1.0;

// Of a triangle's homogeneous places: 0 where it is seen from its edge.
double VolumeOf(const std::array<DVec3, 3>& places) {
  return glm::dot(places[0], glm::cross(places[1], places[2]));
}

// The greatest of k·z over z in [lo, hi].
double GreatestOver(double lo, double hi, double k) { return k > 0 ? k * hi : k * lo; }

}  // namespace

DepthRaster::DepthRaster(const LightView& view, const RasterFrame& frame)
    : view_(view),
      scale_(view.pixels_per_slope()),
      offset_((view.window.min - (view.from_infinity ? DVec2(0.0) : frame.middle)) * scale_),
      eye_(view.from_infinity ? DVec3(DVec2(view.eye) + frame.middle, 0.0)
                              : frame.Sheared(view.eye)),
      near_depth_(view.near * (1 - kNearMargin)),
      vertices_(std::make_unique<RasterVertices>()) {
  const Vec2 scale(scale_), offset(offset_);
  const Vec3 eye(eye_);
  projection_ = {
      .scale_x = scale.x,
      .scale_y = scale.y,
      .offset_x = offset.x,
      .offset_y = offset.y,
      .eye_x = eye.x,
      .eye_y = eye.y,
      .eye_z = eye.z,
      .careful_depth = static_cast<float>(std::max(kCarefulFraction * view.far, near_depth_)),
      .from_infinity = view.from_infinity};
  nearest_.assign(size_t{view.width} * view.height + kRasterLanes,
                  view.from_infinity ? -kNoDepth : 0.0f);
}

DVec3 DepthRaster::ImagePlaceOf(DVec3 q) const {
  if (view_.from_infinity) {
    return DVec3((DVec2(q) + q.z * DVec2(eye_)) * scale_ - offset_, 1.0);
  }
  const double depth = q.z - eye_.z;
  return DVec3((DVec2(q) - DVec2(eye_)) * scale_ - depth * offset_, depth);
}

// Each side of the image is a plane through the eye: a box is beyond it where its corner that is
// least so is.
bool DepthRaster::Misses(const FrameBox& box) const {
  const DVec2 size(view_.width, view_.height);
  const double lo = std::max(double{box.min.z} - eye_.z, 0.0), hi = double{box.max.z} - eye_.z;
  if (!view_.from_infinity && hi < near_depth_) return true;
  for (int axis = 0; axis < 2; ++axis) {
    const double first = offset_[axis] - kMarginPixels;
    const double last = offset_[axis] + size[axis] + kMarginPixels;
    const double least = box.min[axis], most = box.max[axis];
    double from_first, from_last;
    if (view_.from_infinity) {
      const double per_depth = eye_[axis] * scale_[axis];
      from_first = scale_[axis] * most - first + GreatestOver(box.min.z, box.max.z, per_depth);
      from_last = last - scale_[axis] * least + GreatestOver(box.min.z, box.max.z, -per_depth);
    } else {
      from_first = scale_[axis] * (most - eye_[axis]) + GreatestOver(lo, hi, -first);
      from_last = scale_[axis] * (eye_[axis] - least) + GreatestOver(lo, hi, last);
    }
    if (from_first < 0 || from_last < 0) return true;
  }
  return false;
}

RasterImage DepthRaster::Image() {
  return {.nearest = nearest_.data(),
          .width = static_cast<int32_t>(view_.width),
          .height = static_cast<int32_t>(view_.height)};
}

void DepthRaster::Draw(const PlacedCaster& caster, const std::stop_token& stop) {
  if (view_.empty() || Misses(caster.bounds())) return;
  const Instance& instance = caster.instance();
  std::array<uint16_t, kClusterTriangles> deferred;
  for (size_t k = 0; k < caster.cluster_count() && !stop.stop_requested(); ++k) {
    if (Misses(caster.BoxOf(k))) continue;
    const RasterCut cut{.mask = instance.alpha_mask.get(),
                        .cutoff = instance.alpha_cutoff,
                        .from_infinity = view_.from_infinity,
                        .uvs = instance.mesh->uvs().data(),
                        .vertices = caster.VerticesOf(k)};
    const RasterCut* const holes = caster.is_cut() ? &cut : nullptr;
    const size_t count =
        DrawCluster(caster.Cluster(k), projection_, Image(), holes, *vertices_, deferred.data());
    for (size_t i = 0; i < count; ++i) DrawCarefully(caster, k, deferred[i], holes);
  }
}

void DepthRaster::DrawCarefully(const PlacedCaster& caster, size_t cluster, size_t triangle,
                                const RasterCut* cut) {
  const uint16_t* const corners = caster.Cluster(cluster).corners + 3 * triangle;
  std::array<ClipCorner, 3> clip;
  std::array<DVec3, 3> places;
  std::array<double, 3> nears;
  std::array<Vec2, 3> uvs{};
  for (size_t k = 0; k < 3; ++k) {
    const uint32_t vertex = caster.VerticesOf(cluster)[corners[k]];
    const DVec3 q = caster.PositionOf(vertex);
    places[k] = ImagePlaceOf(q);
    nears[k] = view_.from_infinity ? -q.z : 1.0 / places[k].z;
    if (cut) uvs[k] = cut->uvs[vertex];
    // Where the kernel draws it, so that it meets its neighbours there.
    clip[k] = {places[k], vertices_->At(corners[k]), vertices_->IsWithinReach(corners[k])};
  }
  // From infinitely far w is 1, beyond any plane before it.
  const ClippedTriangle kept =
      ClipTriangle(clip, view_.from_infinity ? 0.5 : near_depth_, kMaxReach);
  if (kept.count < 3 || VolumeOf(places) == 0) return;
  const RasterPlanes planes = PlanesThrough(places, nears, uvs);
  for (size_t i = 2; i < kept.count; ++i) {
    DrawTriangle({kept.corners[0].at, kept.corners[i - 1].at, kept.corners[i].at}, planes, Image(),
                 cut);
  }
}

// A pixel r = (x, y, 1) is Σ λ_k p_k of the corners, λ_k = r · (p_i × p_j) / (p_k · (p_i × p_j)),
// and what is linear in the triangle is Σ λ_k value_k times its depth there.
RasterPlanes DepthRaster::PlanesThrough(const std::array<DVec3, 3>& places,
                                        const std::array<double, 3>& nears,
                                        const std::array<Vec2, 3>& uvs) const {
  const double volume = VolumeOf(places);
  DVec3 near(0.0), u(0.0), v(0.0);
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (size_t k = 0; k < 3; ++k) {
    const DVec3 share = glm::cross(places[(k + 1) % 3], places[(k + 2) % 3]) / volume;
    near += share * (view_.from_infinity ? nears[k] : 1.0);
    u += share * double{uvs[k].x};
    v += share * double{uvs[k].y};
    const bool is_behind = !view_.from_infinity && places[k].z < near_depth_;
    if (!is_behind) least = std::min(least, nears[k]);
    most = std::max(most, is_behind ? 1.0 / near_depth_ : nears[k]);
  }
  const auto plane = [](DVec3 p) {
    return LinearField{.at_origin = p.z, .per_column = p.x, .per_row = p.y};
  };
  return {.near = plane(near),
          .least = static_cast<float>(least),
          .most = static_cast<float>(most),
          .u = plane(u),
          .v = plane(v)};
}

DepthMap DepthRaster::Finish() && {
  DepthMap map{.view = view_, .depths = std::move(nearest_)};
  map.depths.resize(size_t{view_.width} * view_.height);
  for (float& depth : map.depths) depth = view_.from_infinity ? -depth : 1.0f / depth;
  return map;
}

}  // namespace penumbra
