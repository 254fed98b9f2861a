#include "render/light_view/shadow_layers.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <span>

#include "render/light_view/ray_block.h"
#include "render/math/parallel_for.h"

namespace penumbra {
namespace {

// The part of the depth, from infinitely far of the view's depth range, within which two surfaces
// are one: ten times what two depth sources differ by where a surface is steep.
constexpr double kSameSurface = 0x1p-11;
// The part of the place's size by which a ray starts beyond what it has met.
constexpr double kStep = 0x1p-19;
// Surfaces that a ray may pass by.
constexpr int kMostSteps = 256;

uint32_t BlocksOf(uint32_t pixels) { return (pixels + kBlock - 1) / kBlock; }

enum class Way : int8_t { kFromLight = 1, kTowardsLight = -1 };

}  // namespace

// The rays of one view, through the pixels of a block at a time.
class ShadowLayerTracer::Rays {
 public:
  Rays(const LightView& view, RTCScene scene, std::span<const Part> parts)
      : view_(view), scene_(scene), parts_(parts) {
    rtcInitIntersectContext(&context_);
    context_.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    const DVec3 eye = view.frame.ToWorld(view.eye);
    for (size_t k = 0; k < kPacket; ++k) packet_.ray.dir_z[k] = 1.0f;
    step_ = kStep * (glm::length(eye) + std::max(std::abs(view.near), std::abs(view.far)));
  }

  void MoveTo(uint32_t block_x, uint32_t block_y) { x_ = kBlock * block_x, y_ = kBlock * block_y; }
  bool IsPixel(size_t k) const { return X(k) < view_.width && Y(k) < view_.height; }
  size_t PixelOf(size_t k) const { return size_t{Y(k)} * view_.width + X(k); }

  Starts StartsAt(const DepthMap& nearest) const {
    Starts starts;
    for (size_t k = 0; k < kPacket; ++k) {
      if (!IsPixel(k) || nearest.depths[PixelOf(k)] == kNoDepth) continue;
      const double depth = nearest.depths[PixelOf(k)];
      const double same = kSameSurface * (view_.from_infinity ? view_.far - view_.near : depth);
      starts.lanes[k] = -1;
      starts.before[k] = depth - same, starts.behind[k] = depth + same;
      starts.end[k] = view_.far + same, starts.same[k] = same;
    }
    return starts;
  }

  // The first of what casts from there on.
  Met FindCaster(const Lanes& lanes, const Depths& from, Way way) {
    return Find(lanes, from, way, [](const Part& part, auto&&) { return part.casts; });
  }
  // Of what would be lit, were it not for what is before it.
  Met FindReceiver(const Lanes& lanes, const Depths& from, Way way) {
    return Find(lanes, from, way, [](const Part& part, const auto& faces_light) {
      return part.receives && (part.solid_sign == 0 || faces_light());
    });
  }
  // The last one that is no further off than what was met, and may be that.
  Met FindReceiverAt(const Met& met, Lanes lanes, const Depths& same) {
    Depths from{};
    for (size_t k = 0; k < kPacket; ++k) {
      if (!met.HasHit(k)) lanes[k] = 0;
      if (lanes[k] != 0) from[k] = met.depths[k] + 0.5 * same[k];
    }
    return FindReceiver(lanes, from, Way::kTowardsLight);
  }

 private:
  uint32_t X(size_t k) const { return x_ + static_cast<uint32_t>(k % kBlock); }
  uint32_t Y(size_t k) const { return y_ + static_cast<uint32_t>(k / kBlock); }
  DVec2 CenterOf(size_t k) const { return DVec2(X(k) + 0.5, Y(k) + 0.5); }
  // Away from the light, a metre of depth long.
  DVec3 DirectionOf(size_t k) const {
    return view_.PointAt(CenterOf(k), 1.0) - view_.PointAt(CenterOf(k), 0.0);
  }

  void Start(size_t k, double depth, Way way) {
    const DVec3 origin = view_.PointAt(CenterOf(k), depth);
    const DVec3 direction = static_cast<double>(way) * DirectionOf(k);
    RTCRay16& ray = packet_.ray;
    ray.org_x[k] = static_cast<float>(origin.x), ray.dir_x[k] = static_cast<float>(direction.x);
    ray.org_y[k] = static_cast<float>(origin.y), ray.dir_y[k] = static_cast<float>(direction.y);
    ray.org_z[k] = static_cast<float>(origin.z), ray.dir_z[k] = static_cast<float>(direction.z);
    ray.tnear[k] = ray.time[k] = 0.0f;
    ray.tfar[k] = std::numeric_limits<float>::infinity();
    if (!view_.from_infinity && way == Way::kTowardsLight) {
      ray.tfar[k] = static_cast<float>(depth);  // the eye
    }
    ray.mask[k] = ~0u, ray.id[k] = static_cast<unsigned>(k), ray.flags[k] = 0;
    packet_.hit.geomID[k] = packet_.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
  }

  bool FacesLight(size_t k, const Part& part) const {
    const Mesh& mesh = *part.instance->mesh;
    std::array<DVec3, 3> corners;
    for (size_t c = 0; c < 3; ++c) {
      const uint32_t vertex = mesh.indices()[3 * size_t{packet_.hit.primID[k]} + c];
      corners[c] = DVec3(TransformPoint(part.instance->world_from_mesh, mesh.positions()[vertex]));
    }
    const DVec3 normal = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
    return part.solid_sign * glm::dot(normal, DirectionOf(k)) < 0;
  }

  template <typename Accept>
  Met Find(Lanes lanes, Depths from, Way way, const Accept& accept) {
    Met met;
    met.depths.fill(kNoDepth), met.parts.fill(kNoBlocker);
    for (int step = 0; step < kMostSteps; ++step) {
      if (lanes.none()) break;
      for (size_t k = 0; k < kPacket; ++k) {
        if (lanes[k] != 0) Start(k, from[k], way);
      }
      rtcIntersect16(lanes.wanted.data(), scene_, &context_, &packet_);
      for (size_t k = 0; k < kPacket; ++k) {
        if (lanes[k] != 0) lanes[k] = Take(k, way, accept, from[k], met) ? 0 : -1;
      }
    }
    return met;
  }

  // Whether the ray has ended; otherwise `from` is beyond what it has met.
  template <typename Accept>
  bool Take(size_t k, Way way, const Accept& accept, double& from, Met& met) const {
    const uint32_t id = packet_.hit.instID[0][k];
    if (packet_.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID) return true;
    const double sign = static_cast<double>(way);
    const double depth = from + sign * double{packet_.ray.tfar[k]};
    if (accept(parts_[id], [&] { return FacesLight(k, parts_[id]); })) {
      met.depths[k] = static_cast<float>(depth), met.parts[k] = id;
      return true;
    }
    from = depth + sign * step_;
    return !view_.from_infinity && !(from > 0);
  }

  const LightView& view_;
  RTCScene scene_;
  std::span<const Part> parts_;
  RTCIntersectContext context_;
  double step_;
  uint32_t x_ = 0, y_ = 0;
  alignas(64) RTCRayHit16 packet_{};
};

// Which parts cast a shadow on others, or are in that of others; any number of threads at a time.
class ShadowLayerTracer::Blockers {
 public:
  Blockers(std::span<const Part> parts, size_t pixels)
      : parts_(parts),
        shadows_(parts.size()),
        is_shadowed_(parts.size()),
        alone_(pixels, kNoBlocker) {}

  void Note(uint32_t blocker, uint32_t receiver) {
    if (blocker == receiver || blocker == kNoBlocker || receiver == kNoBlocker) return;
    shadows_[blocker].store(true, std::memory_order_relaxed);
    is_shadowed_[receiver].store(true, std::memory_order_relaxed);
  }
  // Of a pixel where nothing is behind the part.
  void NoteAlone(size_t pixel, uint32_t part) { alone_[pixel] = part; }

  uint32_t PartAt(size_t pixel) const { return alone_[pixel]; }
  bool IsBlocker(size_t pixel) const {
    const uint32_t part = alone_[pixel];
    if (part == kNoBlocker) return false;
    return !parts_[part].receives || (shadows_[part].load(std::memory_order_relaxed) &&
                                      !is_shadowed_[part].load(std::memory_order_relaxed));
  }

 private:
  std::span<const Part> parts_;
  std::vector<std::atomic<bool>> shadows_, is_shadowed_;
  std::vector<uint32_t> alone_;
};

ShadowLayerTracer::ShadowLayerTracer(const Scene& scene, const Scene& all_surfaces,
                                     const CasterBvhs& bvhs, tbb::task_arena& arena)
    : bvh_(bvhs.Of(all_surfaces, CasterBvhs::Instances::kAll)), arena_(arena) {
  // As the hierarchy has them.
  for (const auto& [id, instance] : all_surfaces.instances()) {
    if (instance->mesh->triangle_count() == 0) continue;
    const auto here = scene.FindInstance(id);
    Part part{.instance = instance.get(),
              .casts = here != nullptr && here->casts,
              .receives = here == nullptr || here->receives,
              .solid_sign = 0};
    if (part.receives && instance->mesh->closure() == MeshClosure::kClosedOutward) {
      part.solid_sign = glm::determinant(glm::dmat3(Mat4(instance->world_from_mesh))) < 0 ? -1 : 1;
    }
    parts_.push_back(part);
  }
}

void ShadowLayerTracer::TraceBlock(const DepthMap& nearest, Rays& rays, Blockers& blockers,
                                   ShadowLayers& layers) const {
  const Starts starts = rays.StartsAt(nearest);
  if (starts.lanes.none()) return;
  const Met caster = rays.FindCaster(starts.lanes, starts.before, Way::kFromLight);
  const Met first = rays.FindReceiver(starts.lanes, starts.behind, Way::kFromLight);
  Lanes shadowed = starts.lanes;
  for (size_t k = 0; k < kPacket; ++k) {
    if (starts.lanes[k] == 0 || first.HasHit(k)) continue;
    blockers.NoteAlone(rays.PixelOf(k), caster.parts[k]);
    shadowed[k] = 0;
  }
  Met last = rays.FindReceiver(shadowed, starts.end, Way::kTowardsLight);
  Depths before_first{}, before_last{};
  for (size_t k = 0; k < kPacket; ++k) {
    if (shadowed[k] == 0) continue;
    if (!last.HasHit(k)) last.depths[k] = first.depths[k];
    before_first[k] = first.depths[k] - starts.same[k];
    before_last[k] = last.depths[k] - starts.same[k];
  }
  const Met near_blocker = rays.FindCaster(shadowed, before_first, Way::kTowardsLight);
  const Met far_blocker = rays.FindCaster(shadowed, before_last, Way::kTowardsLight);
  const Met at_blocker = rays.FindReceiverAt(far_blocker, shadowed, starts.same);
  for (size_t k = 0; k < kPacket; ++k) {
    if (shadowed[k] == 0) continue;
    const size_t pixel = rays.PixelOf(k);
    blockers.Note(caster.parts[k], first.parts[k]);
    blockers.Note(caster.parts[k], last.parts[k]);
    layers.blocked[pixel] = 1;
    layers.first_receiver[pixel] = first.depths[k];
    layers.last_receiver[pixel] = last.depths[k];
    layers.before_first[pixel] = near_blocker.NotBefore(nearest.depths[pixel], k);
    layers.before_last[pixel] = far_blocker.NotBefore(nearest.depths[pixel], k);
    layers.receiver_at_last[pixel] = at_blocker.NotBefore(nearest.depths[pixel], k);
    layers.first_blocker[pixel] = near_blocker.PartOr(caster.parts[k], k);
    layers.last_blocker[pixel] = far_blocker.PartOr(caster.parts[k], k);
  }
}

absl::StatusOr<ShadowLayers> ShadowLayerTracer::Trace(const DepthMap& nearest,
                                                      const std::stop_token& stop) const {
  if (!bvh_->status().ok()) return bvh_->status();
  const size_t pixels = nearest.depths.size();
  ShadowLayers layers{.blocked = std::vector<uint8_t>(pixels),
                      .first_receiver = std::vector<float>(pixels, kNoDepth),
                      .last_receiver = std::vector<float>(pixels, kNoDepth),
                      .before_first = std::vector<float>(pixels, kNoDepth),
                      .before_last = std::vector<float>(pixels, kNoDepth),
                      .receiver_at_last = std::vector<float>(pixels, kNoDepth),
                      .first_blocker = std::vector<uint32_t>(pixels, kNoBlocker),
                      .last_blocker = std::vector<uint32_t>(pixels, kNoBlocker)};
  Blockers blockers(parts_, pixels);
  RunIn(arena_, [&] {
    ParallelFor(BlocksOf(nearest.view.height), [&](uint32_t block_y) {
      Rays rays(nearest.view, bvh_->embree(), parts_);
      if (stop.stop_requested()) return;
      for (uint32_t block_x = 0; block_x < BlocksOf(nearest.view.width); ++block_x) {
        rays.MoveTo(block_x, block_y);
        TraceBlock(nearest, rays, blockers, layers);
      }
    });
  });
  if (stop.stop_requested()) return absl::CancelledError("stopped");
  for (size_t i = 0; i < pixels; ++i) {
    if (!blockers.IsBlocker(i)) continue;
    layers.blocked[i] = 1;
    layers.before_first[i] = layers.before_last[i] = nearest.depths[i];
    layers.receiver_at_last[i] = nearest.depths[i];
    layers.first_blocker[i] = layers.last_blocker[i] = blockers.PartAt(i);
  }
  return layers;
}

}  // namespace penumbra
