// The hard shadow of one light sample.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "render/scene/receiver.h"
#include "render/technique/soft_texture/coverage_kernel.h"
#include "render/technique/soft_texture/edge_flags.h"
#include "render/technique/soft_texture/occluder_set.h"
#include "render/technique/soft_texture/receiver_transform.h"
#include "render/technique/soft_texture/shadow_bitmap.h"
#include "render/technique/soft_texture/soft_texture_params.h"

namespace penumbra {

// Draws hard shadows; keeps its scratch memory from one sample to the next. One for each thread.
class HardShadow {
 public:
  HardShadow(const ReceiverPatch& receiver, VisibilityMethod method)
      : receiver_(receiver), method_(method) {}

  // Sets the bit of every texel of `window` whose line to the sample is blocked by one of
  // `occluders`, whose outlines `seen` has for a set of samples with this one in it.
  void Draw(const OccluderSet& occluders, const SeenOutlines& seen, const LightSample& sample,
            const ReceiverTransform& map, const TexelWindow& window, ShadowBitmap& bitmap);

 private:
  // Consecutive groups [begin, end) that are drawn in one go.
  void DrawRun(const OccluderSet& occluders, size_t begin, size_t end, bool near_light,
               const ReceiverTransform& map, const TexelWindow& window, ShadowBitmap& bitmap);
  void FlagOutline(const OccluderSet& occluders, const OccluderGroup& group,
                   const SilhouetteEdges& edges, const LightSample& sample,
                   const TexelWindow& window);
  // Whether all of the group's shadow is near enough to the window to be drawn from its outline.
  bool IsInGuardBand(const OccluderGroup& group, const ReceiverTransform& map,
                     const TexelWindow& window) const;
  EdgeFlags& FlagsFor(const TexelWindow& window);
  void DrawCarefully(const OccluderSet& occluders, uint32_t triangle, const Instance* masked,
                     const ReceiverTransform& map, const TexelWindow& window,
                     ShadowBitmap& bitmap) const;

  const ReceiverPatch& receiver_;
  const VisibilityMethod method_;
  TexelProjection projection_{};
  ProjectedVertices projected_;
  std::vector<uint32_t> deferred_;
  SilhouetteList outline_;
  std::optional<EdgeFlags> flags_;  // made on first use
};

}  // namespace penumbra
