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

  // What follows is drawn with the outlines that `lenders` see, one after another, neighbours on
  // the light: finds them among the edges in `seen`, of all together where that is quicker.
  void FindOutlines(std::span<const LightSample> lenders, const OccluderSet& occluders,
                    std::span<const SeenOutline> seen);

  // Sets the bit of every texel of `window` whose line to the sample is blocked by one of
  // `occluders`. If any of them has an outline, that is the one of number `neighbour` of the
  // lenders last given to FindOutlines, with the same occluders and `seen`.
  void Draw(const OccluderSet& occluders, std::span<const SeenOutline> seen,
            const LightSample& sample, size_t neighbour, const ReceiverTransform& map,
            const TexelWindow& window, ShadowBitmap& bitmap);

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
  // The outline of number `o` of the occluders that a lender sees.
  const SilhouetteList& OutlineOf(size_t o, size_t neighbour, const OccluderSet& occluders,
                                  const SeenOutline& seen);
  void DrawOutlined(const OutlinedOccluder& occluder, const SeenOutline& seen,
                    const SilhouetteList& outline, const View& view);
  // Whether all of a box's shadow is near enough to the window to be drawn from its outline.
  bool IsInGuardBand(const Aabb& box, const View& view) const;
  EdgeFlags& FlagsFor(const TexelWindow& window);
  void DrawCarefully(const OccluderSet& occluders, uint32_t triangle, const Instance* masked,
                     const View& view) const;

  const ReceiverPatch& receiver_;
  const ShadowRules rules_;
  ProjectedVertices projected_;
  std::vector<uint32_t> deferred_, visible_;
  std::vector<LightSample> lenders_;
  std::vector<size_t> list_of_;  // for each lender: its list, which equal ones share
  // Those lists, for each outlined occluder; none where there are few edges.
  std::vector<std::vector<SilhouetteList>> found_;
  SilhouetteList outline_;
  std::optional<EdgeFlags> flags_;  // made on first use
};

}  // namespace penumbra
