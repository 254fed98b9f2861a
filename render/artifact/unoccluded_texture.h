// What a unit of a light gives each texel of a patch where nothing is in the way, computed at few
// points and interpolated within a stated error.
//
//   UnoccludedTexture factors(light, receiver, 1e-3);
//   factors.ForEachBlock(stop, [&](const TexelBlock& block, std::span<const float> values) { … });
//
// How the error is bounded. A factor is written as F = c(x) S(x). Here c is exact at every texel
// and has all the kinks: the distance to the plane of a rectangle or disk, 0 behind one that shines
// from its front alone; a spot's falloff; otherwise 1. S is smooth in the patch's plane, for the
// part of a light that is above that plane is the same for all of its points:
//
//   S(x) = ∫ h(y) / (π r^p) dy,   h: height of y above the plane,
//
// p = 4 for planar lights, and p = 3 with a single y for points and for spheres that the plane does
// not cut. Along a unit vector e of the plane, at angle ψ to the ray from x to y,
//
//   ∂² r^-p / ∂e² = p ((p + 2) cos² ψ − 1) r^-p-2,
//
// so that |S''| ≤ max |p ((p + 2) cos² ψ − 1)| / r² · S, and S changes within a cell of diagonal D
// by a factor of at most (1 + D / r_min)^p. Bilinear interpolation in a cell with sides a and b is
// off by at most (a² max |S_aa| + b² max |S_bb|) / 8. So in relation to F, at every texel, the
// error is below
//
//   (1 + D / r_min)^p (a² m_a + b² m_b) / (8 r_min²),   m = max |p ((p + 2) cos² ψ − 1)|,
//
// in which only distances and angles between a cell and the light occur. Cells are made as large as
// this allows; where that is hardly larger than a texel, or S has no bound (the light touches the
// patch, a sphere is cut by its plane), every texel is computed by itself.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>

#include "render/artifact/light_extent.h"
#include "render/math/vec.h"
#include "render/scene/area_light.h"
#include "render/scene/receiver.h"
#include "render/scene/unoccluded_light.h"

namespace penumbra {

struct TexelBlock {
  uint32_t x = 0, y = 0;
  uint32_t width = 0, height = 0;
};

class UnoccludedTexture {
 public:
  // Texels of a block's side; the last ones of a row or column have fewer.
  static constexpr uint32_t kBlockSide = 32;

  // relative_error  bound on |error| / F at each texel, besides rounding to single precision;
  //                 0: every texel is computed by itself
  UnoccludedTexture(const AreaLight& light, const ReceiverPatch& receiver, double relative_error);

  // Calls `shade` once for each block, from several threads, with its factors row by row: times
  // LightStrength(light) they are UnoccludedRadiance at the texel centres, of a two-sided receiver
  // from both sides. Blocks not begun when `stop` is requested are left out.
  void ForEachBlock(
      const std::stop_token& stop,
      const std::function<void(const TexelBlock&, std::span<const float>)>& shade) const;

 private:
  struct Cells {
    uint32_t along_u = 0, along_v = 0;  // 0: every texel by itself
  };
  // How far away the light is at least from a block, and how steep rays can be.
  struct Nearness {
    double distance;
    double sharpness_u, sharpness_v;  // max |p ((p + 2) cos² ψ − 1)|
  };

  // Texel coordinates: whole numbers are centres.
  DVec3 At(double i, double j) const { return origin_ + i * step_u_ + j * step_v_; }
  double Exact(DVec3 point) const;
  double Smooth(DVec3 point) const;  // S
  double Kinked(DVec3 point) const;  // c
  Nearness NearnessOf(const TexelBlock& block) const;
  Cells CellsFor(const TexelBlock& block) const;
  void Fill(const TexelBlock& block, std::span<float> factors, uint32_t stride) const;
  void FillExactly(const TexelBlock& block, std::span<float> factors, uint32_t stride) const;
  void Interpolate(const TexelBlock& block, Cells cells, std::span<float> factors,
                   uint32_t stride) const;

  const AreaLight light_;
  const ReceiverPatch receiver_;
  const double relative_error_;
  const LightExtent extent_;
  DVec3 origin_, step_u_, step_v_, normal_;
  bool is_lit_in_front_ = true, is_lit_behind_ = false;
  double power_ = 0;  // p; 0: S is constant
  bool is_smooth_;    // S has a bound
  double nearest_height_ = 0;
  AreaLight smooth_light_;  // whose factor is c S with the simplest c: no falloff, two-sided
  std::optional<SpotCone> cone_;
};

}  // namespace penumbra
