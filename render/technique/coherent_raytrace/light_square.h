// The unit square that stands for a light, as each point of a scene sees it.
//
//   const LightSquare square(light);
//   const LightSquare::Seen seen = square.From(point);
//   const Vec3 target = seen.TargetAt({0.5f, 0.5f});   // the light's middle
//   seen.PartsBehind(grid, blockers, count, parts);    // what of the light blockers hide
#pragma once

#include <cstddef>
#include <cstdint>

#include "render/math/vec.h"
#include "render/scene/area_light.h"
#include "render/technique/coherent_raytrace/square_kernel.h"

namespace penumbra {

// Even on the square is even on the light, by the same maps as SampleLight's: on a sphere, on the
// disc that the point sees of it; on a distant light, on the disc of directions as projected.
class LightSquare {
 public:
  using Kind = SquareKind;

  explicit LightSquare(const AreaLight& light);

  Kind kind() const { return frame_.kind; }
  // The light has no extent: all of the square is one point.
  bool is_single() const { return kind() == Kind::kPoint || kind() == Kind::kDirection; }
  bool is_at_infinity() const { return kind() == Kind::kSky || kind() == Kind::kDirection; }
  // How wide the light is, a rectangle along its shorter side, in m; 0 if it has no extent or is at
  // infinity.
  float width() const;
  // A rectangle or disk that shines from its front alone has its back towards `point`.
  bool IsDarkAt(Vec3 point) const;

  // The place on the light (SquareView) of a point of the square.
  Vec2 PlaceOf(Vec2 square) const;

  class Seen {
   public:
    // A position, or of lights at infinity a unit direction.
    Vec3 TargetAt(Vec2 square) const;
    // The same of many, in padded arrays, as those below (kSamplerLanes).
    void TargetsAt(size_t count, const float* u, const float* v, float* x, float* y,
                   float* z) const {
      penumbra::TargetsAt(view_, count, u, v, x, y, z);
    }
    // What of the light blockers hide: the parts of the grid's cells where the rays from the point
    // through them meet it, CellGrid::off where they do not, or only before the blocker.
    void PartsBehind(const CellGrid& grid, const Vec4* blockers, size_t count,
                     uint32_t* part) const {
      penumbra::PartsBehind(view_, grid, blockers, count, part);
    }
    // What of equation (1) depends on the light's point, at places on the light.
    void WeightsAt(const Vec3& normal, size_t count, const float* s, const float* t,
                   float* weight) const {
      penumbra::WeightsAt(view_, normal, count, s, t, weight);
    }
    bool IsAbove(Vec3 target, Vec3 normal) const {
      const bool at_infinity = view_.kind == Kind::kSky || view_.kind == Kind::kDirection;
      return glm::dot(normal, at_infinity ? target : target - view_.point) > 0;
    }
    // Whether all of the light is above the plane through the point with this normal, or none.
    enum class Side { kAbove, kBelow, kBoth };
    Side SideOf(Vec3 normal) const;

   private:
    friend class LightSquare;
    SquareView view_;
  };
  Seen From(Vec3 point) const;

 private:
  void TakeRectangle(const RectangleLight& light);
  void TakeDisk(const DiskLight& light);

  bool two_sided_ = true;
  SquareView frame_;  // all but what depends on the point
};

}  // namespace penumbra
