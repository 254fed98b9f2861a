// An instance's triangles as Embree takes them, by none of the code that is tested.
#pragma once

#include <embree3/rtcore.h>

#include <algorithm>
#include <cstdint>

#include "render/scene/instance.h"

namespace penumbra::testing {

// As it is placed, without holes.
inline void AttachTriangles(RTCDevice device, RTCScene scene, const Instance& instance) {
  const Mesh& mesh = *instance.mesh;
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* const vertices = static_cast<Vec3*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec3), mesh.vertex_count()));
  for (size_t i = 0; i < mesh.vertex_count(); ++i) {
    vertices[i] = TransformPoint(instance.world_from_mesh, mesh.positions()[i]);
  }
  auto* const indices = static_cast<uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(uint32_t), mesh.triangle_count()));
  std::ranges::copy(mesh.indices(), indices);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
}

}  // namespace penumbra::testing
