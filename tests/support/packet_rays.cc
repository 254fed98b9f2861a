#include "tests/support/packet_rays.h"

#include <algorithm>
#include <array>
#include <limits>

#include "render/math/parallel_for.h"
#include "render/technique/coherent_raytrace/point_samples.h"
#include "tests/support/attach_triangles.h"

namespace penumbra::testing {
namespace {

constexpr uint32_t kPacket = 16;

uint16_t SeenFrom(const SurfacePoint& point, size_t index, const LightSquare& square,
                  const PacketRaySettings& settings, RTCScene scene, RTCIntersectContext& context) {
  if (square.IsDarkAt(point.position)) return 0;
  const LightSquare::Seen seen = square.From(point.position);
  SampleBatch samples;
  samples.Add(CellMask::All(settings.side), {settings.side, 1}, SampleSeed(settings.seed, index));
  const Vec3 origin = point.position + settings.surface_offset * point.normal;
  const bool at_infinity = square.is_at_infinity();
  alignas(64) RTCRay16 r;
  alignas(64) std::array<int, kPacket> valid;
  uint16_t count = 0;
  for (uint32_t block = 0; block < settings.side * settings.side / kPacket; ++block) {
    bool any = false;
    for (uint32_t k = 0; k < kPacket; ++k) {
      const uint32_t s = kPacket * block + k;
      const Vec3 target = seen.TargetAt({samples.u[s], samples.v[s]});
      const Vec3 way = at_infinity ? target : target - origin;
      valid[k] = seen.IsAbove(target, point.normal) ? -1 : 0;
      any |= valid[k] != 0;
      r.org_x[k] = origin.x, r.org_y[k] = origin.y, r.org_z[k] = origin.z;
      r.dir_x[k] = way.x, r.dir_y[k] = way.y, r.dir_z[k] = way.z;
      r.tnear[k] = 0;
      r.tfar[k] = at_infinity ? std::numeric_limits<float>::infinity() : 1 - 0x1p-16f;
      r.time[k] = 0, r.mask[k] = ~0u, r.id[k] = k, r.flags[k] = 0;
    }
    if (!any) continue;
    rtcOccluded16(valid.data(), scene, &context, &r);
    for (uint32_t k = 0; k < kPacket; ++k) count += valid[k] != 0 && r.tfar[k] > 0;
  }
  return count;
}

}  // namespace

PacketRays::PacketRays(const Scene& scene)
    : device_(rtcNewDevice(nullptr), rtcReleaseDevice),
      top_(rtcNewScene(device_.get()), rtcReleaseScene) {
  for (const auto& [id, instance] : scene.instances()) {
    if (instance->casts) AttachTriangles(device_.get(), top_.get(), *instance);
  }
  rtcCommitScene(top_.get());
}

std::vector<uint16_t> PacketRays::VisibleFrom(const SurfacePoints& points,
                                              const PacketRaySettings& settings,
                                              tbb::task_arena& arena) const {
  const LightSquare square(settings.light);
  std::vector<uint16_t> visible(points.size());
  RunIn(arena, [&] {
    ParallelFor(points.height, [&](uint32_t row) {
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      if (settings.is_coherent) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
      for (size_t i = size_t{row} * points.width; i < size_t{row + 1} * points.width; ++i) {
        if (!points.is_there[i]) continue;
        visible[i] = SeenFrom(points.points[i], i, square, settings, top_.get(), context);
      }
    });
  });
  return visible;
}

}  // namespace penumbra::testing
