// The projective map that takes the pyramid between a light sample and a receiver to a box.
//
//   const auto map = ReceiverTransform::Create(patch, sample);
//   const DVec3 xyw = map->FromWorld(p);         // homogeneous; u = x / w, v = y / w
#pragma once

#include <optional>

#include "render/math/vec.h"
#include "render/scene/light_sample.h"
#include "render/scene/receiver.h"

namespace penumbra {

// With apex a, base corner b and base edges e_x, e_y, and e_w = b − a:
//
//   x = α_x n_x · (p − b)     n_x = e_w × e_y    α_x = 1 / (n_x · e_x)
//   y = α_y n_y · (p − b)     n_y = e_x × e_w    α_y = 1 / (n_y · e_y)
//   w = α_w n_w · (p − a)     n_w = e_y × e_x    α_w = 1 / (n_w · e_w)
//
// x/w and y/w are the receiver's u and v of the point's shadow, and w falls from 1 on the receiver
// to 0 at the apex, so that depth 1/w runs from 1 to infinity. All three vanish at the apex. For a
// light at infinity e_w is the direction in which light travels, and w is 1 everywhere: the map is
// affine.
//
// Source  Herf 1997, §3.2; derived and tested again in docs/techniques/soft_texture.md
class ReceiverTransform {
 public:
  // nullopt where there is no pyramid: the sample lies in the receiver's plane to within
  // `min_height` metres, or, a direction, to within 2⁻¹⁹ of a radian.
  static std::optional<ReceiverTransform> Create(const Parallelogram& patch,
                                                 const LightSample& sample, double min_height);

  // (x, y, w) of a point in world space.
  DVec3 FromWorld(DVec3 p) const { return FromOffset(p - origin_); }
  // The same of p − origin, as rows: x and y without a constant, w with constant 1.
  DVec3 FromOffset(DVec3 d) const {
    return {glm::dot(row_x_, d), glm::dot(row_y_, d), 1 + glm::dot(row_w_, d)};
  }
  DVec3 row_x() const { return row_x_; }
  DVec3 row_y() const { return row_y_; }
  DVec3 row_w() const { return row_w_; }

  // Metres from the receiver's plane to the sample, positive in front; ±infinity for directions.
  double sample_height() const { return sample_height_; }

 private:
  DVec3 origin_{0.0}, row_x_{0.0}, row_y_{0.0}, row_w_{0.0};
  double sample_height_ = 0;
};

// How far, in metres, something must be from the receiver's plane not to be taken for a part of it.
double SurfaceOffset(const ReceiverPatch& receiver);

}  // namespace penumbra
