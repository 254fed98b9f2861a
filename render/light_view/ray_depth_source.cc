#include "render/light_view/ray_depth_source.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <limits>

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

// What is at the near depth, but for rounding, is seen.
constexpr double kNearMargin = 0x1p-20;

// Rays that grow one metre deeper with each unit of their parameter.
class ViewRays {
 public:
  explicit ViewRays(const LightView& view) : view_(view), pixel_(1.0 / view.pixels_per_slope()) {
    const Basis& axes = view.frame.axes;
    if (view.from_infinity) {
      // They begin before the scene: Embree knows no negative parameters.
      begin_ = view.near - kLeadIn * (view.far - view.near);
      origin_ = view.PointAt(DVec2(0.0), begin_);
      direction_ = axes.n - view.eye.x * axes.s - view.eye.y * axes.t;
    } else {
      origin_ = view.frame.ToWorld(view.eye);
      direction_ = axes.n + view.window.min.x * axes.s + view.window.min.y * axes.t;
    }
  }

  void Fill(uint32_t block_x, uint32_t block_y, RTCRayHit16& packet,
            std::array<int, kPacket>& valid) const {
    for (uint32_t k = 0; k < kPacket; ++k) {
      const uint32_t x = kBlock * block_x + k % kBlock, y = kBlock * block_y + k / kBlock;
      valid[k] = x < view_.width && y < view_.height ? -1 : 0;
      const DVec3 offset =
          (x + 0.5) * pixel_.x * view_.frame.axes.s + (y + 0.5) * pixel_.y * view_.frame.axes.t;
      const Vec3 origin(view_.from_infinity ? origin_ + offset : origin_);
      const Vec3 direction(view_.from_infinity ? direction_ : direction_ + offset);
      RTCRay16& rays = packet.ray;
      rays.org_x[k] = origin.x, rays.org_y[k] = origin.y, rays.org_z[k] = origin.z;
      rays.dir_x[k] = direction.x, rays.dir_y[k] = direction.y, rays.dir_z[k] = direction.z;
      rays.tnear[k] =
          view_.from_infinity ? 0.0f : static_cast<float>(view_.near * (1 - kNearMargin));
      rays.tfar[k] = std::numeric_limits<float>::infinity();
      rays.time[k] = 0.0f;
      rays.mask[k] = ~0u;
      packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
    }
  }

  double begin() const { return begin_; }

 private:
  const LightView& view_;
  const DVec2 pixel_;
  double begin_ = 0.0;  // the depth where the parameter is 0
  DVec3 origin_, direction_;
};

using Blocks = tbb::blocked_range2d<uint32_t>;

void DrawBlocks(RTCScene scene, const ViewRays& view_rays, const Blocks& blocks, DepthMap& map) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  alignas(64) RTCRayHit16 packet;
  alignas(64) std::array<int, kPacket> valid;
  for (uint32_t by = blocks.rows().begin(); by < blocks.rows().end(); ++by) {
    for (uint32_t bx = blocks.cols().begin(); bx < blocks.cols().end(); ++bx) {
      view_rays.Fill(bx, by, packet, valid);
      rtcIntersect16(valid.data(), scene, &context, &packet);
      for (uint32_t k = 0; k < kPacket; ++k) {
        if (valid[k] == 0 || packet.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID) continue;
        const uint32_t x = kBlock * bx + k % kBlock, y = kBlock * by + k / kBlock;
        map.depths[size_t{y} * map.view.width + x] =
            static_cast<float>(view_rays.begin() + double{packet.ray.tfar[k]});
      }
    }
  }
}

}  // namespace

absl::Status RayDepthSource::Draw(std::span<const LightView> views, const std::stop_token& stop,
                                  const Take& take) {
  if (!casters_->status().ok()) return casters_->status();
  if (absl::Status status = CheckViews(views); !status.ok()) return status;
  const auto blocks = [](uint32_t side) { return (side + kBlock - 1) / kBlock; };
  for (size_t i = 0; i < views.size(); ++i) {
    const LightView& view = views[i];
    DepthMap map = NothingSeen(view);
    if (!view.empty()) {
      const ViewRays rays(view);
      const Blocks all(0, blocks(view.height), kBlocksDown, 0, blocks(view.width), kBlocksAcross);
      RunIn(arena_, [&] {
        ParallelForRange(all, [&](const Blocks& some) {
          if (!stop.stop_requested()) DrawBlocks(casters_->embree(), rays, some, map);
        });
      });
    }
    if (stop.stop_requested()) return absl::CancelledError("stopped");
    if (absl::Status status = take(i, std::move(map)); !status.ok()) return status;
  }
  return absl::OkStatus();
}

}  // namespace penumbra
