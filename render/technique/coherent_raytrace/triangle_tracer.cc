#include "render/technique/coherent_raytrace/triangle_tracer.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <limits>

namespace penumbra {
namespace {

constexpr size_t kPacket = 8;

// The last part of a ray, where a light's own surface is: 2^-16 of its length.
constexpr float kLightShare = 1 - 0x1p-16f;

// Learns where rays are blocked: Embree tells filters alone, when any hit will do.
struct BlockerContext {
  RTCIntersectContext embree;
  float* blocked_at;

  static void Note(const RTCFilterFunctionNArguments* args) {
    float* const blocked_at = reinterpret_cast<const BlockerContext*>(args->context)->blocked_at;
    for (unsigned i = 0; i < args->N; ++i) {
      if (args->valid[i] != -1) continue;
      blocked_at[RTCRayN_id(args->ray, args->N, i)] = RTCRayN_tfar(args->ray, args->N, i);
    }
  }
};

void FillPacket(const ShadowRays& rays, Vec3 origin, size_t first, RTCRay8& packet,
                std::array<int, kPacket>& valid) {
  for (size_t k = 0; k < kPacket; ++k) {
    const size_t i = std::min(first + k, rays.x.size() - 1);
    valid[k] = first + k < rays.x.size() ? -1 : 0;
    const Vec3 target(rays.x[i], rays.y[i], rays.z[i]);
    const Vec3 direction = rays.at_infinity ? target : target - origin;
    packet.org_x[k] = origin.x, packet.org_y[k] = origin.y, packet.org_z[k] = origin.z;
    packet.dir_x[k] = direction.x, packet.dir_y[k] = direction.y, packet.dir_z[k] = direction.z;
    packet.tnear[k] = 0.0f;
    packet.tfar[k] = rays.at_infinity ? std::numeric_limits<float>::infinity() : kLightShare;
    packet.time[k] = 0.0f;
    packet.mask[k] = ~0u;
    packet.id[k] = static_cast<unsigned>(i);
    packet.flags[k] = 0;
  }
}

}  // namespace

float SurfaceOffset(const Aabb& bounds) { return 0x1p-14f * glm::length(bounds.extent()); }

void TriangleTracer::Trace(const ShadowRays& rays, std::span<float> blocked_at,
                           TraceCounts& counts) const {
  BlockerContext context{.blocked_at = blocked_at.data()};
  rtcInitIntersectContext(&context.embree);
  if (rays.wants_blockers) context.embree.filter = BlockerContext::Note;
  std::ranges::fill(blocked_at, kUnblocked);
  const Vec3 origin = rays.from.position + surface_offset_ * rays.from.normal;
  alignas(64) RTCRay8 packet;
  alignas(64) std::array<int, kPacket> valid;
  for (size_t first = 0; first < rays.x.size(); first += kPacket) {
    FillPacket(rays, origin, first, packet, valid);
    rtcOccluded8(valid.data(), casters_->embree(), &context.embree, &packet);
    if (rays.wants_blockers) continue;
    for (size_t k = 0; k < kPacket; ++k) {
      if (valid[k] != 0 && packet.tfar[k] < 0) blocked_at[first + k] = 0.0f;
    }
  }
  counts.rays += rays.x.size();
  counts.packets += (rays.x.size() + kPacket - 1) / kPacket;
}

}  // namespace penumbra
