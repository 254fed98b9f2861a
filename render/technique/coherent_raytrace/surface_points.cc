#include "render/technique/coherent_raytrace/surface_points.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "render/math/aabb.h"
#include "render/math/parallel_for.h"

namespace penumbra {
namespace {

constexpr uint32_t kBlock = 4;  // pixels along a side of a packet
constexpr uint32_t kPacket = kBlock * kBlock;

// Directions through pixels, towards the scene.
struct EyeRays {
  explicit EyeRays(const PicturePixels& picture)
      : eye(picture.camera.eye),
        world_from_clip(glm::inverse(ClipFromWorld(picture.camera, picture.aspect()))),
        size(picture.width, picture.height) {}

  Vec3 Through(uint32_t x, uint32_t y) const {
    const DVec2 at = DVec2(2 * (x + 0.5) / size.x - 1, 1 - 2 * (y + 0.5) / size.y);
    const DVec4 p = world_from_clip * DVec4(at, 1.0, 1.0);  // on the near plane
    return Vec3(glm::normalize(DVec3(p) / p.w - eye));
  }

  DVec3 eye;
  DMat4 world_from_clip;
  DVec2 size;
};

void TakeHits(const RTCRayHit16& packet, const std::array<int, kPacket>& valid,
              const std::array<size_t, kPacket>& places, const EyeRays& rays,
              SurfacePoints& points) {
  for (uint32_t k = 0; k < kPacket; ++k) {
    if (valid[k] == 0 || packet.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID) continue;
    const Vec3 direction(packet.ray.dir_x[k], packet.ray.dir_y[k], packet.ray.dir_z[k]);
    const Vec3 across(packet.hit.Ng_x[k], packet.hit.Ng_y[k], packet.hit.Ng_z[k]);
    const float length = glm::length(across);
    if (!(length > 0)) continue;
    const Vec3 normal = (glm::dot(across, direction) > 0 ? -1.0f : 1.0f) / length * across;
    points.points[places[k]] = {Vec3(rays.eye + double{packet.ray.tfar[k]} * DVec3(direction)),
                                normal};
    points.is_there[places[k]] = 1;
  }
}

void SeeBlock(RTCScene scene, const EyeRays& rays, const PixelRect& part, uint32_t bx, uint32_t by,
              SurfacePoints& points) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  alignas(64) RTCRayHit16 packet;
  alignas(64) std::array<int, kPacket> valid;
  std::array<size_t, kPacket> places{};
  for (uint32_t k = 0; k < kPacket; ++k) {
    const uint32_t x = kBlock * bx + k % kBlock, y = kBlock * by + k / kBlock;
    valid[k] = x < part.width && y < part.height ? -1 : 0;
    places[k] = size_t{y} * part.width + x;
    const Vec3 direction = rays.Through(part.x + x, part.y + y), eye(rays.eye);
    RTCRay16& r = packet.ray;
    r.org_x[k] = eye.x, r.org_y[k] = eye.y, r.org_z[k] = eye.z;
    r.dir_x[k] = direction.x, r.dir_y[k] = direction.y, r.dir_z[k] = direction.z;
    r.tnear[k] = 0.0f, r.tfar[k] = std::numeric_limits<float>::infinity();
    r.time[k] = 0.0f, r.mask[k] = ~0u, r.id[k] = k, r.flags[k] = 0;
    packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
  }
  rtcIntersect16(valid.data(), scene, &context, &packet);
  TakeHits(packet, valid, places, rays, points);
}

constexpr uint32_t kMortonBits = 21;  // a coordinate

// Its bits three apart.
uint64_t Spread(uint64_t bits) {
  bits = (bits | bits << 32) & 0x001f'0000'0000'ffff;
  bits = (bits | bits << 16) & 0x001f'0000'ff00'00ff;
  bits = (bits | bits << 8) & 0x100f'00f0'0f00'f00f;
  bits = (bits | bits << 4) & 0x10c3'0c30'c30c'30c3;
  return (bits | bits << 2) & 0x1249'2492'4924'9249;
}

std::vector<uint32_t> AlongMortonCurve(const std::vector<SurfacePoint>& points) {
  Aabb bounds;
  for (const SurfacePoint& point : points) bounds.Add(point.position);
  const Vec3 size = bounds.extent();
  const double cells = double{1u << kMortonBits} - 1;
  const double scale = cells / std::max<double>({size.x, size.y, size.z, 1e-30f});
  std::vector<std::pair<uint64_t, uint32_t>> places;
  places.reserve(points.size());
  for (const SurfacePoint& point : points) {
    const DVec3 at = scale * DVec3(point.position - bounds.min);
    uint64_t code = 0;
    for (int axis = 0; axis < 3; ++axis) {
      code |= Spread(static_cast<uint64_t>(std::clamp(at[axis], 0.0, cells))) << axis;
    }
    places.emplace_back(code, static_cast<uint32_t>(places.size()));
  }
  std::ranges::sort(places);
  std::vector<uint32_t> order;
  order.reserve(places.size());
  for (const auto& [code, i] : places) order.push_back(i);
  return order;
}

}  // namespace

SurfacePoints NoPoints(GridExtent grid) {
  const size_t count = size_t{grid.width} * grid.height;
  return {.width = grid.width,
          .height = grid.height,
          .points = std::vector<SurfacePoint>(count),
          .is_there = std::vector<uint8_t>(count)};
}

absl::StatusOr<SurfacePoints> VisiblePoints(const CasterBvh& instances,
                                            const PicturePixels& picture, tbb::task_arena& arena,
                                            const std::stop_token& stop) {
  const PixelRect part = picture.part();
  SurfacePoints points = NoPoints({part.width, part.height});
  const EyeRays rays(picture);
  const uint32_t across = (part.width + kBlock - 1) / kBlock;
  RunIn(arena, [&] {
    ParallelFor((part.height + kBlock - 1) / kBlock, [&](uint32_t by) {
      if (stop.stop_requested()) return;
      for (uint32_t bx = 0; bx < across; ++bx) {
        SeeBlock(instances.embree(), rays, part, bx, by, points);
      }
    });
  });
  if (stop.stop_requested()) return absl::CancelledError("stopped");
  return points;
}

SurfacePoints ListedPoints(const GivenPoints& given) {
  SurfacePoints points = NoPoints(GridOf(given));
  for (size_t i = 0; i < points.size(); ++i) {
    const auto& [position, normal] = (*given.points)[i];
    points.points[i] = {position, Vec3(glm::normalize(DVec3(normal)))};
    points.is_there[i] = 1;
  }
  const float as_they_come = SpacingOf(points);
  points.order = AlongMortonCurve(points.points);
  if (!(SpacingOf(points) < as_they_come)) points.order.clear();
  return points;
}

float SpacingOf(const SurfacePoints& points) {
  std::vector<float> distances;
  for (size_t place = 1; place < points.size(); ++place) {
    if (place % points.width == 0) continue;
    const size_t i = points.Visited(place), before = points.Visited(place - 1);
    if (!points.is_there[i] || !points.is_there[before]) continue;
    distances.push_back(glm::distance(points.points[i].position, points.points[before].position));
  }
  if (distances.empty()) return 0.0f;
  const auto middle = distances.begin() + static_cast<ptrdiff_t>(distances.size() / 2);
  std::ranges::nth_element(distances, middle);
  return *middle;
}

}  // namespace penumbra
