// One epipolar ray through one depth image.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "absl/functional/function_ref.h"
#include "render/technique/coherent_raytrace/image_ray.h"
#include "render/technique/coherent_raytrace/shadow_tracer.h"

namespace penumbra {

// What makes hierarchical traversal faster, each by itself (Agrawala et al. 2000, §5.1.1 and
// §5.1.2). With none of them it is that of Lischinski and Rappoport 1998.
struct RayAccelerations {
  // A node that is one surface, from one side of which to the other the ray goes, blocks it. Where
  // blockers are asked for it is not used.
  bool connectedness = true;
  bool min_max_clipping = true;     // of the ray, in every node
  bool ranking = true;              // images in which the ray is short first
  bool clear_miss = true;           // a ray that one image sees all of is free
  bool occlusion_intervals = true;  // further images are asked only about what is hidden so far

  static RayAccelerations None() { return {false, false, false, false, false}; }
};

// Pixels are floors at their depths; walls join the floors of neighbours that show one surface.
//
// The ray is before a pixel's surface, or behind it. Where it goes from the one to the other
// within a pixel, or over an edge with a wall, it is blocked; over an edge without one it passes a
// silhouette.
class ImageTraversal {
 public:
  ImageTraversal(bool clips, bool uses_surfaces) : clips_(clips), uses_surfaces_(uses_surfaces) {}

  // Follows the ray through an interval in s that ImageRay::Clip returned. Where it goes through a
  // surface it is blocked if the block stands, and goes on otherwise. Where it is blocked first;
  // nullopt: nowhere, and where it is behind surfaces is put to the end of `hidden`, in s, with a
  // pixel and a half more at either end.
  std::optional<double> Trace(const DepthPyramid& image, const ImageRay& ray, WayInterval s,
                              absl::FunctionRef<bool(double s)> stands,
                              std::vector<WayInterval>& hidden);

  // Whether the ray is before all surfaces for a pixel and a half about a place in `seen`, which
  // ImageRay::Clip returned: where Trace over all of it would report nothing as hidden.
  bool IsOpenAt(const DepthPyramid& image, const ImageRay& ray, WayInterval seen, double s);

  uint64_t steps() const { return steps_; }

 private:
  // A part of the segment, in shares of it, and the node that it is in.
  struct Piece {
    float from, to;
    int level, x, y;
  };
  enum class Side { kUnknown, kBefore, kBehind };

  bool Visit(Piece piece);
  bool VisitChildren(const Piece& piece);
  bool Enter(Side side, const Piece& piece);
  bool HasWall(const Piece& piece) const;
  float PixelIn(const Piece& piece, float at, int& x, int& y) const;
  bool BlockAt(float at);
  float NearnessAt(float at) const { return origin_.z + at * way_.z; }
  double ParameterAt(float at) const { return s_.from + double{at} * (s_.to - s_.from); }

  const bool clips_;
  const bool uses_surfaces_;
  WayInterval s_{};                // the segment
  Vec3 origin_{0.0f}, way_{0.0f};  // of the segment, which `at` in [0, 1] runs through
  const DepthPyramid* image_ = nullptr;
  const absl::FunctionRef<bool(double s)>* stands_ = nullptr;
  Side side_ = Side::kUnknown;
  Piece last_{};
  float blocked_at_ = 0.0f;
  std::vector<Piece> hidden_;
  uint64_t steps_ = 0;
};

}  // namespace penumbra
