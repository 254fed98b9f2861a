#include "render/technique/coherent_raytrace/triangle_tracer.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <limits>

namespace penumbra {
namespace {

constexpr size_t kPortion = 256;  // rays that Embree is given at a time

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

// Rays as Embree takes them.
class Stream {
 public:
  explicit Stream(bool at_infinity)
      : at_infinity_(at_infinity),
        end_(at_infinity ? std::numeric_limits<float>::infinity() : kRayEnd) {
    zeros_.fill(0.0f);
    mask_.fill(~0u);
    flags_.fill(0u);
  }

  size_t size() const { return size_; }
  size_t room() const { return kPortion - size_; }

  // Rays first to first + count of all.
  void Add(const ShadowRays& rays, size_t first, size_t count, Vec3 origin) {
    const Vec3 off = at_infinity_ ? Vec3(0.0f) : origin;
    const float* const x = &rays.x[first];
    const float* const y = &rays.y[first];
    const float* const z = &rays.z[first];
    for (size_t k = 0; k < count; ++k) {
      const size_t at = size_ + k;
      org_x_[at] = origin.x, org_y_[at] = origin.y, org_z_[at] = origin.z;
      dir_x_[at] = x[k] - off.x, dir_y_[at] = y[k] - off.y, dir_z_[at] = z[k] - off.z;
      tfar_[at] = end_;
      id_[at] = static_cast<unsigned>(first + k);
    }
    size_ += count;
  }

  void Trace(RTCScene scene, RTCIntersectContext* context) {
    const RTCRayNp rays{.org_x = org_x_.data(),
                        .org_y = org_y_.data(),
                        .org_z = org_z_.data(),
                        .tnear = zeros_.data(),
                        .dir_x = dir_x_.data(),
                        .dir_y = dir_y_.data(),
                        .dir_z = dir_z_.data(),
                        .time = zeros_.data(),
                        .tfar = tfar_.data(),
                        .mask = mask_.data(),
                        .id = id_.data(),
                        .flags = flags_.data()};
    rtcOccludedNp(scene, context, &rays, static_cast<unsigned>(size_));
  }
  void NoteBlocked(std::span<float> blocked_at) const {
    for (size_t k = 0; k < size_; ++k) {
      if (tfar_[k] < 0) blocked_at[id_[k]] = 0.0f;
    }
  }
  void Clear() { size_ = 0; }

 private:
  using Floats = std::array<float, kPortion>;
  const bool at_infinity_;
  const float end_;
  size_t size_ = 0;
  alignas(64) Floats org_x_, org_y_, org_z_, dir_x_, dir_y_, dir_z_, tfar_, zeros_;
  alignas(64) std::array<unsigned, kPortion> mask_, id_, flags_;
};

}  // namespace

float SurfaceOffset(const Aabb& bounds) {
  if (bounds.empty()) return 0.0f;
  const Vec3 furthest = glm::max(glm::abs(bounds.min), glm::abs(bounds.max));
  return 0x1p-19f * std::max({glm::length(bounds.extent()), furthest.x, furthest.y, furthest.z});
}

void TriangleTracer::Trace(const ShadowRays& rays, std::span<float> blocked_at,
                           TraceCounts& counts) const {
  BlockerContext context{.blocked_at = blocked_at.data()};
  rtcInitIntersectContext(&context.embree);
  if (rays.wants_blockers) context.embree.filter = BlockerContext::Note;
  std::ranges::fill(blocked_at, kUnblocked);
  Stream stream(rays.at_infinity);
  const auto trace = [&] {
    stream.Trace(casters_->embree(), &context.embree);
    if (!rays.wants_blockers) stream.NoteBlocked(blocked_at);
    stream.Clear();
  };
  size_t i = 0;
  for (const RayFan& fan : rays.fans) {
    const Vec3 origin = fan.from.position + surface_offset_ * fan.from.normal;
    while (i < fan.end) {
      const size_t count = std::min(fan.end - i, stream.room());
      stream.Add(rays, i, count, origin);
      i += count;
      if (stream.room() == 0) trace();
    }
  }
  if (stream.size() > 0) trace();
  counts.rays += rays.x.size();
}

}  // namespace penumbra
