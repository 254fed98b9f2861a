#include "render/reference/ray_visibility.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <limits>
#include <optional>

#include "render/math/parallel_for.h"
#include "render/reference/occluder_triangles.h"
#include "tbb/blocked_range2d.h"

namespace penumbra {
namespace {

constexpr uint32_t kBlock = 4;  // texels along a side of a packet
constexpr uint32_t kPacket = kBlock * kBlock;
// The part of a ray, next to the sample, in which nothing blocks it.
constexpr double kFarMargin = 0x1.0p-16;

// Keeps a hit on a masked surface only where the mask is opaque.
void FilterMasked(const RTCFilterFunctionNArguments* args) {
  const auto* triangles = static_cast<const std::vector<OccluderTriangle>*>(args->geometryUserPtr);
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] != -1) continue;
    const OccluderTriangle& triangle = (*triangles)[RTCHitN_primID(args->hit, args->N, i)];
    if (!triangle.masked) continue;
    const double u = RTCHitN_u(args->hit, args->N, i), v = RTCHitN_v(args->hit, args->N, i);
    const DVec2 uv = (1 - u - v) * triangle.uvs[0] + u * triangle.uvs[1] + v * triangle.uvs[2];
    if (!MaskBlocks(*triangle.masked, uv)) args->valid[i] = 0;
  }
}

// The rays from a block of texels. Tracing changes nothing but `rays.tfar`, so that what all
// samples share is filled in once.
struct Packet {
  alignas(64) RTCRay16 rays;
  alignas(64) std::array<int, kPacket> valid;
};

Packet PacketOfBlock(const ReceiverPatch& receiver, uint32_t bi, uint32_t bj) {
  Packet packet{};
  for (uint32_t k = 0; k < kPacket; ++k) {
    const uint32_t i = kBlock * bi + k % kBlock, j = kBlock * bj + k / kBlock;
    packet.valid[k] = i < receiver.width && j < receiver.height ? -1 : 0;
    const Vec3 p =
        receiver.TexelCenter(std::min(i, receiver.width - 1), std::min(j, receiver.height - 1));
    packet.rays.org_x[k] = p.x;
    packet.rays.org_y[k] = p.y;
    packet.rays.org_z[k] = p.z;
    packet.rays.mask[k] = ~0u;
  }
  return packet;
}

// A sample with its blocking interval, as the packets take it.
struct Target {
  Vec3 point;
  bool at_infinity;
  float near;
  float far;
  bool reaches() const { return near < far; }
};

std::vector<Target> TargetsOf(const Parallelogram& patch, std::span<const LightSample> samples,
                              double surface_offset) {
  std::vector<Target> targets;
  for (const LightSample& sample : samples) {
    const RayInterval interval = BlockingInterval(patch, sample, surface_offset);
    targets.push_back({sample.point, sample.at_infinity, static_cast<float>(interval.near),
                       static_cast<float>(interval.far)});
  }
  return targets;
}

// Afterwards rays.tfar is negative where the ray is blocked: Embree writes −∞ for a hit.
void TracePacket(RTCScene scene, RTCIntersectContext& context, const Target& target,
                 Packet& packet) {
  RTCRay16& rays = packet.rays;
  const float from = target.at_infinity ? 0.0f : 1.0f;
  for (uint32_t k = 0; k < kPacket; ++k) {
    rays.dir_x[k] = target.point.x - from * rays.org_x[k];
    rays.dir_y[k] = target.point.y - from * rays.org_y[k];
    rays.dir_z[k] = target.point.z - from * rays.org_z[k];
    rays.tnear[k] = target.near;
    rays.tfar[k] = target.far;
  }
  rtcOccluded16(packet.valid.data(), scene, &context, &rays);
}

// The index, in row order, of a block's texel k; nullopt outside of the receiver.
std::optional<size_t> TexelOf(const ReceiverPatch& receiver, uint32_t bi, uint32_t bj, uint32_t k) {
  const size_t i = kBlock * bi + k % kBlock, j = kBlock * bj + k / kBlock;
  if (i >= receiver.width || j >= receiver.height) return std::nullopt;
  return j * receiver.width + i;
}

}  // namespace

struct RayVisibility::Embree {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  std::vector<OccluderTriangle> triangles;

  ~Embree() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }

  void AddTriangles() {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<Vec3*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                                RTC_FORMAT_FLOAT3, sizeof(Vec3),
                                                                3 * triangles.size()));
    auto* indices = static_cast<uint32_t*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(uint32_t), triangles.size()));
    bool any_masked = false;
    for (size_t t = 0; t < triangles.size(); ++t) {
      for (size_t k = 0; k < 3; ++k) {
        vertices[3 * t + k] = Vec3(triangles[t].corners[k]);
        indices[3 * t + k] = static_cast<uint32_t>(3 * t + k);
      }
      any_masked |= triangles[t].masked != nullptr;
    }
    rtcSetGeometryUserData(geometry, &triangles);
    if (any_masked) rtcSetGeometryOccludedFilterFunction(geometry, FilterMasked);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
  }

  // Calls visit(bi, bj, trace) for every block; trace(target) returns the packet's 16 tfar.
  template <typename Visitor>
  void ForEachBlock(const ReceiverPatch& receiver, tbb::task_arena& arena,
                    const Visitor& visit) const {
    const auto blocks = [](uint32_t side) { return (side + kBlock - 1) / kBlock; };
    const tbb::blocked_range2d<uint32_t> range(0, blocks(receiver.height), 4, 0,
                                               blocks(receiver.width), 4);
    const auto visit_part = [&](const tbb::blocked_range2d<uint32_t>& part) {
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
      for (uint32_t bj = part.rows().begin(); bj < part.rows().end(); ++bj) {
        for (uint32_t bi = part.cols().begin(); bi < part.cols().end(); ++bi) {
          Packet packet = PacketOfBlock(receiver, bi, bj);
          visit(bi, bj, [&](const Target& target) -> const float* {
            TracePacket(scene, context, target, packet);
            return packet.rays.tfar;
          });
        }
      }
    };
    RunIn(arena, [&] { ParallelForRange(range, visit_part); });
  }
};

RayVisibility::RayVisibility(const Scene& scene, Intersector intersector)
    : embree_(std::make_unique<Embree>()) {
  embree_->device = rtcNewDevice(nullptr);
  embree_->scene = rtcNewScene(embree_->device);
  rtcSetSceneBuildQuality(embree_->scene, RTC_BUILD_QUALITY_HIGH);
  if (intersector == Intersector::kRobust) {
    rtcSetSceneFlags(embree_->scene, RTC_SCENE_FLAG_ROBUST);
  }
  embree_->triangles = OccluderTriangles(scene);
  triangle_count_ = embree_->triangles.size();
  if (triangle_count_ > 0) embree_->AddTriangles();
  rtcCommitScene(embree_->scene);
}

RayVisibility::~RayVisibility() = default;

VisibilityMap RayVisibility::Counts(const ReceiverPatch& receiver,
                                    std::span<const LightSample> samples, double surface_offset,
                                    tbb::task_arena& arena) const {
  const auto n = static_cast<uint32_t>(samples.size());
  VisibilityMap map{.width = receiver.width, .height = receiver.height, .sample_count = n};
  map.counts.assign(size_t{receiver.width} * receiver.height, static_cast<uint16_t>(n));
  const auto targets = TargetsOf(receiver.patch, samples, surface_offset);
  embree_->ForEachBlock(receiver, arena, [&](uint32_t bi, uint32_t bj, const auto& trace) {
    std::array<int, kPacket> blocked{};
    for (const Target& target : targets) {
      if (!target.reaches()) continue;
      const float* const tfar = trace(target);
      for (uint32_t k = 0; k < kPacket; ++k) blocked[k] += tfar[k] < 0;
    }
    for (uint32_t k = 0; k < kPacket; ++k) {
      const auto texel = TexelOf(receiver, bi, bj, k);
      if (texel) map.counts[*texel] -= static_cast<uint16_t>(blocked[k]);
    }
  });
  return map;
}

std::vector<uint8_t> RayVisibility::Blocked(const ReceiverPatch& receiver,
                                            std::span<const LightSample> samples,
                                            double surface_offset, tbb::task_arena& arena) const {
  const size_t texels = size_t{receiver.width} * receiver.height;
  std::vector<uint8_t> result(samples.size() * texels, 0);
  const auto targets = TargetsOf(receiver.patch, samples, surface_offset);
  embree_->ForEachBlock(receiver, arena, [&](uint32_t bi, uint32_t bj, const auto& trace) {
    for (size_t s = 0; s < targets.size(); ++s) {
      if (!targets[s].reaches()) continue;
      const float* const tfar = trace(targets[s]);
      for (uint32_t k = 0; k < kPacket; ++k) {
        const auto texel = TexelOf(receiver, bi, bj, k);
        if (texel) result[s * texels + *texel] = tfar[k] < 0;
      }
    }
  });
  return result;
}

RayInterval BlockingInterval(const Parallelogram& patch, const LightSample& sample,
                             double surface_offset) {
  const DVec3 normal = glm::normalize(glm::cross(DVec3(patch.edge_u), DVec3(patch.edge_v)));
  const DVec3 towards =
      sample.at_infinity ? DVec3(sample.point) : DVec3(sample.point) - DVec3(patch.origin);
  const double height = std::abs(glm::dot(normal, towards));
  const double far = sample.at_infinity ? std::numeric_limits<double>::infinity() : 1 - kFarMargin;
  // Of a direction `height` is the sine of its angle to the plane: 2 µm per metre is edge-on.
  const bool is_edge_on = height <= (sample.at_infinity ? 2e-6 : surface_offset);
  return {.near = is_edge_on ? far : surface_offset / height, .far = far};
}

}  // namespace penumbra
