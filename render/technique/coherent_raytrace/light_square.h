// The unit square that stands for a light, as each point of a scene sees it.
//
//   const LightSquare square(light);
//   const LightSquare::Seen seen = square.From(point);
//   const Vec3 target = seen.TargetAt({0.5f, 0.5f});   // the light's middle
//   const Vec2 cell = seen.SquareOf(blocker);          // what of the light the blocker hides
#pragma once

#include <cstddef>
#include <cstdint>

#include "render/math/vec.h"
#include "render/scene/area_light.h"
#include "render/technique/coherent_raytrace/sampler_kernel.h"

namespace penumbra {

// Even on the square is even on the light, by the same maps as SampleLight's: on a sphere, on the
// disc that the point sees of it; on a distant light, on the disc of directions as projected.
class LightSquare {
 public:
  enum class Kind { kRectangle, kDisk, kSphere, kSky, kPoint, kDirection };

  explicit LightSquare(const AreaLight& light);

  Kind kind() const { return kind_; }
  // The light has no extent: all of the square is one point.
  bool is_single() const { return kind_ == Kind::kPoint || kind_ == Kind::kDirection; }
  bool is_at_infinity() const { return kind_ == Kind::kSky || kind_ == Kind::kDirection; }
  // How wide the light is, a rectangle along its shorter side, in m; 0 if it has no extent or is at
  // infinity.
  float width() const;
  // A rectangle or disk that shines from its front alone has its back towards `point`.
  bool IsDarkAt(Vec3 point) const;

  // What is beyond these is hidden nowhere on the square.
  static constexpr float kOutside = 2.0f;

  class Seen {
   public:
    // A position, or of lights at infinity a unit direction.
    Vec3 TargetAt(Vec2 square) const;
    // The same of many. Those on a rectangle are the same for all points.
    void TargetsAt(size_t count, const float* u, const float* v, float* x, float* y,
                   float* z) const {
      if (kind_ == Kind::kRectangle) {
        for (size_t i = 0; i < count; ++i) {
          x[i] = origin_.x + u[i] * u_.x + v[i] * v_.x;
          y[i] = origin_.y + u[i] * u_.y + v[i] * v_.y;
          z[i] = origin_.z + u[i] * u_.z + v[i] * v_.z;
        }
        return;
      }
      for (size_t i = 0; i < count; ++i) {
        const Vec3 target = TargetAt({u[i], v[i]});
        x[i] = target.x, y[i] = target.y, z[i] = target.z;
      }
    }
    // Where the ray from the point through `blocker` meets the light; kOutside where it does not,
    // or only before the blocker.
    Vec2 SquareOf(Vec3 blocker) const;
    // The same of many: the parts of the grid's cells that they hide (PartsBehind).
    void PartsBehind(const CellGrid& grid, const Vec4* blockers, size_t count,
                     uint32_t* part) const;
    // cos θ cos θ' / r² of equation (1), per area of the square, up to a factor that is the same
    // all over the light.
    float WeightAt(Vec2 square, Vec3 normal) const;
    bool IsAbove(Vec3 target, Vec3 normal) const {
      const bool at_infinity = kind_ == Kind::kSky || kind_ == Kind::kDirection;
      return glm::dot(normal, at_infinity ? target : target - point_) > 0;
    }
    // Whether all of the light is above the plane through the point with this normal, or none.
    enum class Side { kAbove, kBelow, kBoth };
    Side SideOf(Vec3 normal) const;

   private:
    friend class LightSquare;
    Vec2 OnDisk(Vec2 square) const;
    Vec2 DiskOf(Vec3 blocker) const;

    Kind kind_;
    Vec3 point_{0.0f};
    Vec3 origin_{0.0f};                      // the square's (0, 0), or the disc's middle
    Vec3 u_{0.0f}, v_{0.0f}, n_{0.0f};       // along the square or the disc's radii; n_ of length 1
    Vec3 dual_u_{0.0f}, dual_v_{0.0f};       // dot(u_, dual_u_) = 1, across v_
    float height_ = 0.0f;                    // of the light's plane over the point, along n_
    float along_u_ = 0.0f, along_v_ = 0.0f;  // the point's own place on the square or disc
    float radius_ = 0.0f;
  };
  Seen From(Vec3 point) const;

 private:
  void TakeRectangle(const RectangleLight& light);
  void TakeDisk(const DiskLight& light);

  Kind kind_ = Kind::kPoint;
  bool two_sided_ = true;
  Seen frame_;  // all but what depends on the point
};

}  // namespace penumbra
