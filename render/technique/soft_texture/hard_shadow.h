// The hard shadow of one light sample.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "render/scene/receiver.h"
#include "render/technique/soft_texture/coverage_kernel.h"
#include "render/technique/soft_texture/edge_flags.h"
#include "render/technique/soft_texture/occluder_set.h"
#include "render/technique/soft_texture/receiver_transform.h"
#include "render/technique/soft_texture/shadow_bitmap.h"
#include "render/technique/soft_texture/soft_texture_params.h"

namespace penumbra {

// How shadows are drawn; makes no difference but of time.
struct ShadowRules {
  VisibilityMethod method = VisibilityMethod::kAuto;
  bool cull = true;  // leave out what cannot cast onto the texture; otherwise draw everything
};

// Draws hard shadows; keeps its scratch memory from one sample to the next. One for each thread.
class HardShadow {
 public:
  HardShadow(const ReceiverPatch& receiver, const ShadowRules& rules)
      : receiver_(receiver), rules_(rules) {}

  // What follows are samples among `samples`, neighbours on the light: of the edges in `seen`, only
  // those are looked at from now on that one of them can see. Once for each sample would not pay.
  void NarrowTo(std::span<const LightSample> samples, const OccluderSet& occluders,
                std::span<const SeenOutline> seen);

  // Sets the bit of every texel of `window` whose line to the sample is blocked by one of
  // `occluders`, whose outlines `seen` has for a set of samples with this one in it.
  void Draw(const OccluderSet& occluders, std::span<const SeenOutline> seen,
            const LightSample& sample, const ReceiverTransform& map, const TexelWindow& window,
            ShadowBitmap& bitmap);

 private:
  // Of one sample.
  struct View {
    const LightSample& sample;
    const ReceiverTransform& map;
    const TexelWindow& window;
    TexelProjection projection;
    UnitBoxSides sides;
    double near_height;  // from here on up a vertex can be too near to the light
    ShadowBitmap& bitmap;
  };

  void DrawPieces(const OccluderSet& occluders, const View& view);
  // Pieces [begin, end), which are drawn in one go.
  void DrawRun(const OccluderSet& occluders, size_t begin, size_t end, bool near_light,
               const View& view);
  void DrawOutlined(const OutlinedOccluder& occluder, const SeenOutline& seen,
                    const SilhouetteEdges& edges, const View& view);
  // Whether all of a box's shadow is near enough to the window to be drawn from its outline.
  bool IsInGuardBand(const Aabb& box, const View& view) const;
  EdgeFlags& FlagsFor(const TexelWindow& window);
  void DrawCarefully(const OccluderSet& occluders, uint32_t triangle, const Instance* masked,
                     const View& view) const;

  const ReceiverPatch& receiver_;
  const ShadowRules rules_;
  ProjectedVertices projected_;
  std::vector<uint32_t> deferred_, visible_;
  std::vector<std::optional<SilhouetteEdges>> narrowed_;  // of the outlined; absent: all seen
  SilhouetteList outline_;
  std::optional<EdgeFlags> flags_;  // made on first use
};

}  // namespace penumbra
