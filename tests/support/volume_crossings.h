// How many triangles of a mesh each pixel's ray meets before its surface: what a stencil buffer
// would count, in double precision.
//
//   VolumeCrossings crossings(eye, inverse_depths);
//   crossings.Add(volume.vertices, volume.indices);
//   if (crossings.IsOdd(pixel)) …
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/math/vec.h"

namespace penumbra::testing {

struct EyeImage {
  DMat4 clip_from_world;
  uint32_t width, height;  // pixels; row 0 is the lowest
  double near;             // m: nothing nearer is drawn
};

// Each edge belongs to the triangle on one side of it, whatever triangles meet there: no ray slips
// through between them and none meets both. Nothing is cut but by the near plane, ray by ray.
class VolumeCrossings {
 public:
  // inverse_depths  of the surface that each pixel shows, in 1/m along the view; 0: none
  VolumeCrossings(const EyeImage& eye, std::vector<double> inverse_depths);

  // vertices  homogeneous, in world space
  // weights   one a triangle, or none: 1 each
  void Add(std::span<const Vec4> vertices, std::span<const uint32_t> indices,
           std::span<const int8_t> weights = {});
  // Triangles in clip space that lie on the near plane and are before everything; x, y and w count.
  void AddCaps(std::span<const Vec4> clip_corners, int weight = 1);
  void Invert();

  bool IsOdd(size_t pixel) const { return odd_[pixel]; }
  // Weights of triangles whose front was met, less those of others: how many volumes are entered
  // more than are left.
  int Count(size_t pixel) const { return count_[pixel]; }

 private:
  struct Corner {
    DVec3 at;        // homogeneous pixels
    double inverse;  // what it adds to the inverse depth
  };
  Corner CornerOf(const Vec4& world) const;
  void Draw(const Corner& a, const Corner& b, const Corner& c, int weight, bool is_cap);

  EyeImage eye_;
  std::vector<double> surface_;
  std::vector<uint8_t> odd_;
  std::vector<int> count_;
};

}  // namespace penumbra::testing
