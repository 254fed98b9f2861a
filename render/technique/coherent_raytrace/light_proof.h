// Proves, without a ray, that points see parts of a light.
//
//   const LightProof proof(light, scene, {}, arena);
//   const CellMask lit = proof.LitFrom(point, side);
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <vector>

#include "render/scene/area_light.h"
#include "render/scene/point_receiver.h"
#include "render/scene/scene.h"
#include "render/technique/coherent_raytrace/cell_mask.h"
#include "render/technique/coherent_raytrace/light_square.h"
#include "render/technique/coherent_raytrace/nearest_depths.h"
#include "tbb/task_arena.h"

namespace penumbra {

struct ProofSettings {
  uint32_t pixels = 1024;  // along the longer side of a view
  // What a surface may rise over the plane through the point within a pixel, in pixels' widths at
  // its depth.
  double bias = 0.1;
  // Proofs from the middles of the light's quarters as well: a tenth fewer rays, for five pictures
  // instead of one, which did not pay at 512 × 512 points.
  bool has_quarters = false;
};

// A part of the light as a picture from a point of it shows what is before it: pixels that its
// window spans to either side, per nearness.
struct LightPart {
  DVec2 low, high;
};

// Let e be a point of a convex light, p a point before it and q one of a caster between p and the
// light, in the hull of both. The way from e to q lies in the hull as well. So the first thing that
// e sees on that way is in the hull too: were anything in it, a picture from e would show
// something in it. The hull at nearness n (1/z) fills a window of the picture about p's own pixel,
// of the light's size times n − n(p). The window is made smaller, beginning with what is nearest
// in the picture, until what is nearest in it is not in the hull, and only pixels of p's own
// surface are left. The picture is made so that nothing is too thin for it (NearestDepths).
//
// A part of the light is proven in the same way, from an eye in it.
//
// Source  ours; the step from the nearest depth to a smaller window is that of hierarchical
//         traversal (Agrawala et al. 2000, §5.1.1) taken with the whole light instead of a ray
class LightProof {
 public:
  // stop  once it is requested nothing that is proven holds
  LightProof(const AreaLight& light, const Scene& scene, const ProofSettings& settings,
             tbb::task_arena& arena, const std::stop_token& stop = {});

  // Cells of a grid of side × side that the point is proven to see all of. The surface's plane must
  // have all of the light above it.
  //
  // Cost  0.1 to 2 µs
  CellMask LitFrom(const SurfacePoint& point, uint32_t side) const;

 private:
  static constexpr size_t kEyes = 5;
  static constexpr int kLevels = 3;  // the light, and halvings of its sides
  using Parts = std::array<std::vector<LightPart>, kLevels>;
  // A picture from one point of the light.
  struct Picture {
    NearestDepths nearest;
    bool covers_all;  // nothing that casts is beyond its edges
    Parts parts;
  };
  // The pictures in all directions from one point of the light.
  using Eye = std::vector<Picture>;

  void AddEye(const AreaLight& light, const Scene& scene, Vec3 place, uint32_t pixels,
              tbb::task_arena& arena, const std::stop_token& stop);
  std::optional<Parts> PartsIn(const LightView& view) const;
  // The point as the eyes see it, found when asked for.
  class Stand;

  size_t EyeIn(int level, uint32_t x, uint32_t y) const;
  bool IsLit(int level, uint32_t x, uint32_t y, Stand& stand) const;
  void Refine(int level, uint32_t x, uint32_t y, Stand& stand, CellMask& lit) const;

  const LightSquare square_;
  double bias_;
  std::vector<Eye> eyes_;  // of the light's middle; then, perhaps, of its quarters
};

}  // namespace penumbra
