#include "render/light_view/placed_triangles.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <span>
#include <utility>

namespace penumbra {
namespace {

// Vertices between two looks at the stop token: about 0.2 ms.
constexpr size_t kVerticesAtATime = size_t{1} << 16;

// Empty where Embree has no memory for it.
template <typename T>
std::span<T> NewBuffer(RTCGeometry geometry, RTCBufferType type, RTCFormat format, size_t count) {
  void* const buffer = rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(T), count);
  return {static_cast<T*>(buffer), buffer ? count : 0};
}

}  // namespace

PlacedTriangles::PlacedTriangles(std::shared_ptr<const Instance> instance, RTCDeviceTy* device,
                                 const std::stop_token& stop)
    : instance_(std::move(instance)),
      geometry_(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE),
                [](RTCGeometry released) { rtcReleaseGeometry(released); }) {
  Place(stop);
  if (instance_->alpha_mask && !instance_->mesh->uvs().empty()) {
    rtcSetGeometryUserData(geometry(), this);
    rtcSetGeometryIntersectFilterFunction(geometry(), Filter);
    rtcSetGeometryOccludedFilterFunction(geometry(), Filter);
  }
  rtcCommitGeometry(geometry());
}

size_t PlacedTriangles::bytes() const {
  return instance_->mesh->positions().size_bytes() + instance_->mesh->indices().size_bytes();
}

void PlacedTriangles::Place(const std::stop_token& stop) {
  const Mesh& mesh = *instance_->mesh;
  const auto vertices =
      NewBuffer<Vec3>(geometry(), RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, mesh.vertex_count());
  for (size_t v = 0; v < vertices.size() && !stop.stop_requested();) {
    const size_t end = std::min(vertices.size(), v + kVerticesAtATime);
    for (; v < end; ++v) {
      vertices[v] = TransformPoint(instance_->world_from_mesh, mesh.positions()[v]);
    }
  }
  using Corners = std::array<uint32_t, 3>;
  const auto indices = NewBuffer<Corners>(geometry(), RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3,
                                          mesh.triangle_count());
  if (!indices.empty()) {
    std::memcpy(indices.data(), mesh.indices().data(), mesh.indices().size_bytes());
  }
}

bool PlacedTriangles::IsThere(uint32_t triangle, float u, float v) const {
  const Mesh& mesh = *instance_->mesh;
  const uint32_t* const corners = &mesh.indices()[3 * size_t{triangle}];
  const Vec2 uv = (1 - u - v) * mesh.uvs()[corners[0]] + u * mesh.uvs()[corners[1]] +
                  v * mesh.uvs()[corners[2]];
  return instance_->alpha_mask->At(uv) >= instance_->alpha_cutoff;
}

void PlacedTriangles::Filter(const RTCFilterFunctionNArguments* args) {
  const auto& triangles = *static_cast<const PlacedTriangles*>(args->geometryUserPtr);
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] != -1) continue;
    const bool is_there =
        triangles.IsThere(RTCHitN_primID(args->hit, args->N, i), RTCHitN_u(args->hit, args->N, i),
                          RTCHitN_v(args->hit, args->N, i));
    if (!is_there) args->valid[i] = 0;
  }
}

}  // namespace penumbra
