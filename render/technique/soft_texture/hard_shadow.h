// The hard shadow of one light sample.
#pragma once

#include <cstdint>
#include <vector>

#include "render/scene/receiver.h"
#include "render/technique/soft_texture/coverage_kernel.h"
#include "render/technique/soft_texture/occluder_set.h"
#include "render/technique/soft_texture/receiver_transform.h"
#include "render/technique/soft_texture/shadow_bitmap.h"

namespace penumbra {

// Draws hard shadows; keeps its scratch memory from one sample to the next. One for each thread.
class HardShadow {
 public:
  explicit HardShadow(const ReceiverPatch& receiver) : receiver_(receiver) {}

  // Sets the bit of every texel of `window` whose line to the sample is blocked by one of
  // `occluders`.
  void Draw(const OccluderSet& occluders, const ReceiverTransform& map, const TexelWindow& window,
            ShadowBitmap& bitmap);

 private:
  // Consecutive groups [begin, end) that are drawn in one go.
  void DrawRun(const OccluderSet& occluders, size_t begin, size_t end, bool near_light,
               const ReceiverTransform& map, const TexelWindow& window, ShadowBitmap& bitmap);
  void DrawCarefully(const OccluderSet& occluders, uint32_t triangle, const Instance* masked,
                     const ReceiverTransform& map, const TexelWindow& window,
                     ShadowBitmap& bitmap) const;

  const ReceiverPatch& receiver_;
  TexelProjection projection_{};
  ProjectedVertices projected_;
  std::vector<uint32_t> deferred_;
};

}  // namespace penumbra
