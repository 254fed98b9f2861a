// Occluders that are drawn from their outlines.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "render/math/aabb.h"
#include "render/scene/instance.h"
#include "render/scene/light_sample.h"
#include "render/technique/soft_texture/occluder_frame.h"
#include "tbb/task_arena.h"

namespace penumbra {

struct OccluderSet;

// Which occluders are drawn from their outlines.
enum class OutlineRule : uint8_t {
  kNever,
  kWherePossible,
  kWhereCheaper,  // by the cost model of outline_cost.h
};

// An instance above the receiver's plane, of which no vertex is prepared yet.
class OutlinedOccluder {
 public:
  // Null where there is no outline: with an alpha mask, not wholly above the frame's surface
  // offset, so flat that the way back into the mesh is lost, or of more than a million triangles.
  static std::unique_ptr<const OutlinedOccluder> Create(std::shared_ptr<const Instance> instance,
                                                        const OccluderFrame& frame);

  // The sample as the mesh sees it.
  DVec4 InMesh(const LightSample& sample) const {
    return mesh_from_world_ * DVec4(DVec3(sample.point), sample.at_infinity ? 0.0 : 1.0);
  }
  const Instance& instance() const { return *instance_; }
  std::shared_ptr<const Instance> shared_instance() const { return instance_; }
  const OccluderFrame& frame() const { return frame_; }
  const Aabb& bounds() const { return bounds_; }  // holds all vertices, in the frame
  float max_height() const { return max_height_; }
  // Makes every face count +1, whichever way it is seen: ±1.
  int32_t sign() const { return sign_; }

  // The same occluder face by face, for samples from which its outline cannot be drawn. Made on
  // first use; any thread may ask.
  const OccluderSet& FaceByFace() const;

  ~OutlinedOccluder();

 private:
  OutlinedOccluder(std::shared_ptr<const Instance> instance, const OccluderFrame& frame);

  std::shared_ptr<const Instance> instance_;
  OccluderFrame frame_;
  DMat4 mesh_from_world_{1.0};
  int32_t sign_ = 1;
  Aabb bounds_;
  float max_height_ = 0;
  mutable std::once_flag faces_once_;
  mutable std::unique_ptr<const OccluderSet> faces_;
};

// The edges of an outline that any of some samples can see, and the vertices that they run between.
struct SeenOutline {
  const SilhouetteEdges* all = nullptr;     // the mesh's
  std::optional<SilhouetteEdges> selected;  // absent: all, by the mesh's vertices
  std::vector<float> x, y, z;               // in the frame, padded for whole vectors

  const SilhouetteEdges& edges() const { return selected ? *selected : *all; }
};

// Shapes  G occluders → G outlines
// Cost    as finding each outline once
std::vector<SeenOutline> OutlinesSeenFrom(
    std::span<const std::unique_ptr<const OutlinedOccluder>> occluders,
    std::span<const LightSample> samples, tbb::task_arena& arena);

}  // namespace penumbra
