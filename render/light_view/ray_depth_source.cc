#include "render/light_view/ray_depth_source.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>
#include <vector>

#include "render/math/parallel_for.h"
#include "tbb/blocked_range2d.h"

namespace penumbra {
namespace {

constexpr uint32_t kBlock = 4;  // pixels along a side of a packet
constexpr uint32_t kPacket = kBlock * kBlock;

// Blocks, down and across, that a thread traces before it may be given others: 16 × 32 pixels take
// it 20 to 100 µs.
constexpr uint32_t kBlocksDown = 4, kBlocksAcross = 8;

// The part of the depths between near and far by which rays from infinitely far begin before near.
constexpr double kLeadIn = 0x1p-10;

// Rays that grow one metre deeper with each unit of their parameter, as packets of Embree's.
class ViewRays {
 public:
  explicit ViewRays(const LightView& view) : view_(view) {
    const Basis& axes = view.frame.axes;
    const DVec2 pixel = 1.0 / view.pixels_per_slope();
    right_ = pixel.x * axes.s, down_ = pixel.y * axes.t;
    if (view.from_infinity) {
      // They begin before the scene: Embree knows no negative parameters.
      begin_ = view.near - kLeadIn * (view.far - view.near);
      first_ = view.PointAt(DVec2(0.0), begin_);
      same_ = Vec3(axes.n - view.eye.x * axes.s - view.eye.y * axes.t);
    } else {
      first_ = axes.n + view.window.min.x * axes.s + view.window.min.y * axes.t;
      same_ = Vec3(view.frame.ToWorld(view.eye));
    }
    for (uint32_t k = 0; k < kPacket; ++k) {
      const DVec3 offset = (k % kBlock + 0.5) * right_ + (k / kBlock + 0.5) * down_;
      offset_x_[k] = offset.x, offset_y_[k] = offset.y, offset_z_[k] = offset.z;
    }
  }

  // What Fill leaves as it is.
  void Prepare(RTCRay16& rays) const {
    float* const x = view_.from_infinity ? rays.dir_x : rays.org_x;
    float* const y = view_.from_infinity ? rays.dir_y : rays.org_y;
    float* const z = view_.from_infinity ? rays.dir_z : rays.org_z;
    const auto begin =
        view_.from_infinity ? 0.0f : static_cast<float>(view_.near * (1 - kNearMargin));
    for (uint32_t k = 0; k < kPacket; ++k) {
      x[k] = same_.x, y[k] = same_.y, z[k] = same_.z;
      rays.tnear[k] = begin;
      rays.time[k] = 0.0f;
      rays.mask[k] = ~0u;
      rays.id[k] = k;
      rays.flags[k] = 0;
    }
  }

  void Fill(uint32_t block_x, uint32_t block_y, RTCRayHit16& packet,
            std::array<int, kPacket>& valid) const {
    const uint32_t x0 = kBlock * block_x, y0 = kBlock * block_y;
    const DVec3 corner =
        first_ + static_cast<double>(x0) * right_ + static_cast<double>(y0) * down_;
    RTCRay16& rays = packet.ray;
    float* const x = view_.from_infinity ? rays.org_x : rays.dir_x;
    float* const y = view_.from_infinity ? rays.org_y : rays.dir_y;
    float* const z = view_.from_infinity ? rays.org_z : rays.dir_z;
    for (uint32_t k = 0; k < kPacket; ++k) x[k] = static_cast<float>(corner.x + offset_x_[k]);
    for (uint32_t k = 0; k < kPacket; ++k) y[k] = static_cast<float>(corner.y + offset_y_[k]);
    for (uint32_t k = 0; k < kPacket; ++k) z[k] = static_cast<float>(corner.z + offset_z_[k]);
    for (uint32_t k = 0; k < kPacket; ++k) {
      rays.tfar[k] = std::numeric_limits<float>::infinity();
      packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
      valid[k] = x0 + k % kBlock < view_.width && y0 + k / kBlock < view_.height ? -1 : 0;
    }
  }

  double begin() const { return begin_; }

 private:
  const LightView& view_;
  double begin_ = 0.0;  // the depth where the parameter is 0
  DVec3 right_, down_;  // from pixel to pixel
  DVec3 first_;         // the image's corner: directions; from infinitely far origins
  Vec3 same_;           // of all rays the origin; from infinitely far the direction
  std::array<double, kPacket> offset_x_, offset_y_, offset_z_;  // of pixels' middles in a block
};

using Blocks = tbb::blocked_range2d<uint32_t>;

uint32_t BlocksOf(uint32_t pixels) { return (pixels + kBlock - 1) / kBlock; }

// Traces of `blocks` those that the view has, and calls `take(pixel, packet, k)` for each ray that
// meets something.
template <typename Take>
void TraceBlocks(RTCScene scene, const ViewRays& view_rays, const Blocks& blocks,
                 const LightView& view, const Take& take) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  alignas(64) RTCRayHit16 packet;
  alignas(64) std::array<int, kPacket> valid;
  view_rays.Prepare(packet.ray);
  const uint32_t down = std::min(blocks.rows().end(), BlocksOf(view.height));
  const uint32_t across = std::min(blocks.cols().end(), BlocksOf(view.width));
  for (uint32_t by = blocks.rows().begin(); by < down; ++by) {
    for (uint32_t bx = blocks.cols().begin(); bx < across; ++bx) {
      view_rays.Fill(bx, by, packet, valid);
      rtcIntersect16(valid.data(), scene, &context, &packet);
      for (uint32_t k = 0; k < kPacket; ++k) {
        if (valid[k] == 0 || packet.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID) continue;
        const uint32_t x = kBlock * bx + k % kBlock, y = kBlock * by + k / kBlock;
        take(size_t{y} * view.width + x, packet, k);
      }
    }
  }
}

}  // namespace

absl::Status RayDepthSource::Draw(std::span<const LightView> views, const std::stop_token& stop,
                                  const Take& take) {
  if (!casters_->status().ok()) return casters_->status();
  if (absl::Status status = CheckViews(views); !status.ok()) return status;
  for (size_t first = 0; first < views.size();) {
    const auto portion = views.subspan(first, ViewsAtOnce(views.subspan(first)));
    std::vector<DepthMap> maps = DrawTogether(portion, stop);
    for (DepthMap& map : maps) {
      if (stop.stop_requested()) return absl::CancelledError("stopped");
      if (absl::Status status = take(first++, std::move(map)); !status.ok()) return status;
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<uint32_t>> RayDepthSource::InstancesIn(
    const LightView& view, const std::stop_token& stop) const {
  if (!casters_->status().ok()) return casters_->status();
  if (absl::Status status = CheckViews({&view, 1}); !status.ok()) return status;
  std::vector<uint32_t> seen(size_t{view.width} * view.height, kNoInstance);
  if (view.empty()) return seen;
  const ViewRays rays(view);
  const auto take = [&](size_t pixel, const RTCRayHit16& packet, uint32_t k) {
    seen[pixel] = packet.hit.instID[0][k];
  };
  RunIn(arena_, [&] {
    ParallelForRange(
        Blocks(0, BlocksOf(view.height), kBlocksDown, 0, BlocksOf(view.width), kBlocksAcross),
        [&](const Blocks& some) {
          if (stop.stop_requested()) return;
          TraceBlocks(casters_->embree(), rays, some, view, take);
        });
  });
  if (stop.stop_requested()) return absl::CancelledError("stopped");
  return seen;
}

// Block by block of all of them, so that what is seen there is in the caches still.
std::vector<DepthMap> RayDepthSource::DrawTogether(std::span<const LightView> views,
                                                   const std::stop_token& stop) {
  std::vector<DepthMap> maps;
  std::vector<ViewRays> rays;
  uint32_t down = 0, across = 0;
  for (const LightView& view : views) {
    maps.push_back(NothingSeen(view));
    rays.emplace_back(view);
    down = std::max(down, BlocksOf(view.height)), across = std::max(across, BlocksOf(view.width));
  }
  RunIn(arena_, [&] {
    ParallelForRange(
        Blocks(0, down, kBlocksDown, 0, across, kBlocksAcross), [&](const Blocks& some) {
          for (size_t i = 0; i < views.size() && !stop.stop_requested(); ++i) {
            if (views[i].empty()) continue;
            const auto take = [&](size_t pixel, const RTCRayHit16& hit, uint32_t k) {
              maps[i].depths[pixel] = static_cast<float>(rays[i].begin() + double{hit.ray.tfar[k]});
            };
            TraceBlocks(casters_->embree(), rays[i], some, views[i], take);
          }
        });
  });
  return maps;
}

}  // namespace penumbra
