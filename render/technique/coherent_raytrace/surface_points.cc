#include "render/technique/coherent_raytrace/surface_points.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "absl/strings/str_cat.h"
#include "render/math/parallel_for.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

constexpr uint32_t kBlock = 4;  // pixels along a side of a packet
constexpr uint32_t kPacket = kBlock * kBlock;
constexpr uint32_t kMaxSide = 16384;  // pixels of a picture, texels of a lightmap

absl::Status RangeError(std::string_view field, uint32_t found) {
  return FieldError(absl::StatusCode::kInvalidArgument, "RANGE", field,
                    absl::StrCat("found ", found, ", need 1 to ", kMaxSide));
}

SurfacePoints NoPoints(uint32_t width, uint32_t height) {
  SurfacePoints points{.width = width, .height = height};
  points.points.resize(size_t{width} * height);
  points.is_there.resize(size_t{width} * height);
  return points;
}

// Directions through pixels, towards the scene.
struct EyeRays {
  EyeRays(const Camera& camera, uint32_t width, uint32_t height)
      : eye(camera.eye),
        world_from_clip(glm::inverse(ClipFromWorld(camera, double(width) / height))),
        size(width, height) {}

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

void SeeBlock(RTCScene scene, const EyeRays& rays, const PixelRect& crop, uint32_t bx, uint32_t by,
              SurfacePoints& points) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  alignas(64) RTCRayHit16 packet;
  alignas(64) std::array<int, kPacket> valid;
  std::array<size_t, kPacket> places{};
  for (uint32_t k = 0; k < kPacket; ++k) {
    const uint32_t x = kBlock * bx + k % kBlock, y = kBlock * by + k / kBlock;
    valid[k] = x < crop.width && y < crop.height ? -1 : 0;
    places[k] = size_t{y} * crop.width + x;
    const Vec3 direction = rays.Through(crop.x + x, crop.y + y), eye(rays.eye);
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

}  // namespace

absl::Status CheckPictureSize(uint32_t width, uint32_t height) {
  if (width < 1 || width > kMaxSide) return RangeError("width", width);
  if (height < 1 || height > kMaxSide) return RangeError("height", height);
  return absl::OkStatus();
}

absl::StatusOr<SurfacePoints> VisiblePoints(const CasterBvh& instances, const Camera& camera,
                                            uint32_t width, uint32_t height, const PixelRect& crop,
                                            tbb::task_arena& arena, const std::stop_token& stop) {
  if (absl::Status status = CheckCamera(camera); !status.ok()) return status;
  if (absl::Status status = CheckPictureSize(width, height); !status.ok()) return status;
  if (crop.width < 1 || crop.height < 1 || crop.x >= width || crop.y >= height ||
      crop.width > width - crop.x || crop.height > height - crop.y) {
    return FieldError(absl::StatusCode::kInvalidArgument, "RANGE", "crop",
                      absl::StrCat("found ", crop.width, " x ", crop.height, " at (", crop.x, ", ",
                                   crop.y, "), need a part of ", width, " x ", height));
  }
  SurfacePoints points = NoPoints(crop.width, crop.height);
  const EyeRays rays(camera, width, height);
  const uint32_t across = (crop.width + kBlock - 1) / kBlock;
  RunIn(arena, [&] {
    ParallelFor((crop.height + kBlock - 1) / kBlock, [&](uint32_t by) {
      if (stop.stop_requested()) return;
      for (uint32_t bx = 0; bx < across; ++bx) {
        SeeBlock(instances.embree(), rays, crop, bx, by, points);
      }
    });
  });
  if (stop.stop_requested()) return absl::CancelledError("stopped");
  return points;
}

absl::StatusOr<SurfacePoints> ListedPoints(std::span<const SurfacePoint> listed) {
  SurfacePoints points = NoPoints(static_cast<uint32_t>(listed.size()), listed.empty() ? 0 : 1);
  const auto invalid = [](size_t i, const char* field, std::string_view reason,
                          std::string_view need) {
    return FieldError(absl::StatusCode::kInvalidArgument, reason,
                      absl::StrCat("points[", i, "].", field), need);
  };
  for (size_t i = 0; i < listed.size(); ++i) {
    const auto& [position, normal] = listed[i];
    if (!IsFinite(position)) return invalid(i, "position", "NON_FINITE", "need finite numbers");
    if (!IsFinite(normal)) return invalid(i, "normal", "NON_FINITE", "need finite numbers");
    const double length = glm::length(DVec3(normal));
    if (!(length > 0)) return invalid(i, "normal", "ZERO_LENGTH", "found length 0, need > 0");
    points.points[i] = {position, Vec3(DVec3(normal) / length)};
    points.is_there[i] = 1;
  }
  return points;
}

float SpacingOf(const SurfacePoints& points) {
  std::vector<float> distances;
  for (size_t i = 1; i < points.size(); ++i) {
    if (i % points.width == 0 || !points.is_there[i] || !points.is_there[i - 1]) continue;
    distances.push_back(glm::distance(points.points[i].position, points.points[i - 1].position));
  }
  if (distances.empty()) return 0.0f;
  const auto middle = distances.begin() + static_cast<ptrdiff_t>(distances.size() / 2);
  std::ranges::nth_element(distances, middle);
  return *middle;
}

}  // namespace penumbra
