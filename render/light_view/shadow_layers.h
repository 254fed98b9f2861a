// What a view's light would fall on behind what it falls on first: which pixels' blockers cast a
// shadow on something, and how far behind it is.
//
//   ShadowLayerTracer tracer(scene, **WithAllSurfaces(scene), bvhs, arena);
//   auto layers = tracer.Trace(nearest, stop);   // a DepthMap of the same scene
#pragma once

#include <cstdint>
#include <memory>
#include <stop_token>
#include <vector>

#include "absl/status/statusor.h"
#include "render/artifact/depth_map.h"
#include "render/light_view/caster_bvh.h"
#include "render/scene/scene.h"
#include "tbb/task_arena.h"

namespace penumbra {

inline constexpr uint32_t kNoBlocker = ~0u;

// H×W each; depths in m as the view measures them, kNoDepth where there is none.
struct ShadowLayers {
  // 1 where what is nearest is a blocker.
  std::vector<uint8_t> blocked;
  // Behind the blocker, the first and the last surface that receives.
  std::vector<float> first_receiver, last_receiver;
  // The last surface of what casts before each of them, but for what all but touches it; what is
  // nearest, where there is no other.
  std::vector<float> before_first, before_last;
  // The last surface that receives no further off than `before_last`, itself if it does; what is
  // nearest, where there is no other.
  std::vector<float> receiver_at_last;
  // Numbers of the instances that these are of; kNoBlocker where nothing is blocked.
  std::vector<uint32_t> first_blocker, last_blocker;
};

// Not every surface that a light sees first casts a shadow: a floor is such a surface too. What is
// nearest at a pixel is a blocker where something that receives lies behind it. Of a receiver that
// bounds a solid the faces away from the light are left out: they get no light anyhow. Where
// nothing lies behind, as beside a table's edge, it is a blocker
//
//   where it is of an instance that does not receive;
//   where it is of one that shadows another instance in the view, and that no other one shadows.
//
// So floors that cast are none, and what stands on them is.
class ShadowLayerTracer {
 public:
  // all_surfaces  the scene WithAllSurfaces(`scene`); referred to, as the rest is
  ShadowLayerTracer(const Scene& scene, const Scene& all_surfaces, const CasterBvhs& bvhs,
                    tbb::task_arena& arena);

  // `nearest` is what casting instances show.
  //
  // Errors  kCancelled: stop requested (asked once for each row of blocks); those of CasterBvhs
  absl::StatusOr<ShadowLayers> Trace(const DepthMap& nearest, const std::stop_token& stop) const;

 private:
  // What rays meet, by its place in the hierarchy.
  struct Part {
    const Instance* instance;
    bool casts, receives;
    // Of a solid that receives: 1 where its triangles turn to the outside, −1 where a mirror turned
    // them; otherwise 0.
    int solid_sign;
  };
  class Rays;
  class Blockers;

  // Of one block of pixels.
  void TraceBlock(const DepthMap& nearest, Rays& rays, Blockers& blockers,
                  ShadowLayers& layers) const;

  std::vector<Part> parts_;
  std::shared_ptr<const CasterBvh> bvh_;
  tbb::task_arena& arena_;
};

}  // namespace penumbra
