#include "tests/support/eye_rays.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <glm/gtc/matrix_access.hpp>
#include <limits>

#include "render/math/parallel_for.h"
#include "tests/support/attach_triangles.h"

namespace penumbra::testing {
namespace {

RTCRay RayAlong(Vec3 from, Vec3 way, float far) {
  RTCRay ray{};
  ray.org_x = from.x, ray.org_y = from.y, ray.org_z = from.z;
  ray.dir_x = way.x, ray.dir_y = way.y, ray.dir_z = way.z;
  ray.tfar = far;
  ray.mask = ~0u;
  return ray;
}

}  // namespace

EyeRays::EyeRays(const Scene& scene)
    : device_(rtcNewDevice(nullptr), rtcReleaseDevice),
      top_(rtcNewScene(device_.get()), rtcReleaseScene) {
  rtcSetSceneFlags(top_.get(), RTC_SCENE_FLAG_ROBUST);
  for (const auto& [id, instance] : scene.instances())
    AttachTriangles(device_.get(), top_.get(), *instance);
  rtcCommitScene(top_.get());
}

EyeView EyeRays::See(const EyeImage& eye, tbb::task_arena& arena) const {
  const size_t count = size_t{eye.width} * eye.height;
  EyeView view{std::vector<double>(count), std::vector<Vec3>(count), std::vector<Vec3>(count)};
  const DMat4 world_from_clip = glm::inverse(eye.clip_from_world);
  const auto place = [&](double x, double y, double depth, double z) {
    const DVec4 p = world_from_clip * DVec4(depth * x, depth * y, z, depth);
    return DVec3(p) / p.w;
  };
  // Clip z of a depth: linear in it.
  const auto z_at = [&](double depth) {
    const DVec4 row_z = glm::row(eye.clip_from_world, 2), row_w = glm::row(eye.clip_from_world, 3);
    const double slope =
        glm::dot(DVec3(row_z), DVec3(row_w)) / glm::dot(DVec3(row_w), DVec3(row_w));
    return slope * depth + row_z.w - slope * row_w.w;
  };
  const double near_z = z_at(eye.near), next_z = z_at(2 * eye.near);
  RunIn(arena, [&] {
    ParallelFor(eye.height, [&](uint32_t row) {
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      for (uint32_t column = 0; column < eye.width; ++column) {
        const double x = 2 * (column + 0.5) / eye.width - 1, y = 2 * (row + 0.5) / eye.height - 1;
        const DVec3 from = place(x, y, eye.near, near_z);
        const DVec3 way = place(x, y, 2 * eye.near, next_z) - from;  // as much depth as `near`
        RTCRayHit hit{
            .ray = RayAlong(Vec3(from), Vec3(way), std::numeric_limits<float>::infinity()),
            .hit = {}};
        hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(top_.get(), &context, &hit);
        if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) continue;
        const size_t pixel = size_t{row} * eye.width + column;
        const Vec3 normal = glm::normalize(Vec3(hit.hit.Ng_x, hit.hit.Ng_y, hit.hit.Ng_z));
        view.inverse_depths[pixel] = 1 / (eye.near * (1 + double{hit.ray.tfar}));
        view.points[pixel] = Vec3(from + double{hit.ray.tfar} * way);
        view.normals[pixel] = glm::dot(normal, Vec3(way)) > 0 ? -normal : normal;
      }
    });
  });
  return view;
}

std::vector<uint8_t> EyeRays::Shadow(const EyeView& view, DVec4 light, float offset,
                                     tbb::task_arena& arena) const {
  std::vector<uint8_t> dark(view.points.size());
  RunIn(arena, [&] {
    ParallelFor(view.points.size(), [&](size_t pixel) {
      if (view.inverse_depths[pixel] == 0) return;
      const Vec3 way = Vec3(DVec3(light) - light.w * DVec3(view.points[pixel]));
      if (glm::dot(way, view.normals[pixel]) <= 0) {
        dark[pixel] = 1;
        return;
      }
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      RTCRay ray = RayAlong(view.points[pixel] + offset * view.normals[pixel], way,
                            light.w == 0 ? std::numeric_limits<float>::infinity() : 1 - 0x1p-16f);
      rtcOccluded1(top_.get(), &context, &ray);
      dark[pixel] = ray.tfar < 0;
    });
  });
  return dark;
}

}  // namespace penumbra::testing
