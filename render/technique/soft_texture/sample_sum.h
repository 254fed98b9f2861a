// The sum of what each visible sample of a light sends to each texel, equation 3.2.
//
//   SampleSum sum(light, receiver, surface_offset, /*sums_all=*/false);
//   for each band: sum.AddBand(samples, window, hidden, hidden_too);
//   sum.Visible(row)[i] / n · LightStrength(light)   // radiance that a white receiver reflects
//
//   L = L_light / n Σ_i a_i cos θ_i cos θ'_i / (π r_i²) v_i
//
// The area a_i that a sample would stand for if it were the only one is, by the density with which
// SampleLight places samples:
//
//   rectangle, disk   the light's area: samples lie evenly
//   sphere            π R² / cos φ, φ from the axis towards the patch's centre: samples lie evenly
//                     on the disc that is seen from there, whose area is cos φ times the surface's
//   distant           cos θ'/r² a_i is a solid angle, π sin² α / cos φ of a disc in the sky of half
//                     angle α and axis at φ; with irradiance for radiance π sin² α goes away
//
// The outermost ring of a sphere's n samples holds 1/n of the disc and has 2 √n as its mean of
// 1 / cos φ; no sample gets more than that.
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "render/scene/area_light.h"
#include "render/scene/light_sample.h"
#include "render/scene/receiver.h"
#include "render/technique/soft_texture/coverage_kernel.h"
#include "render/technique/soft_texture/kept_shadows.h"
#include "render/technique/soft_texture/sum_kernel.h"

namespace penumbra {

// Whether samples of `light` differ in what they send: points, spots and a sun without size have
// one sample, of which equation 4.1 says all.
bool HasUnequalSamples(const AreaLight& light);

// Shadows of samples 0, 1, … of a call, whose row 0 is row `first_row` of the texture.
struct BandShadows {
  const SampleShadows* shadows = nullptr;  // null: nothing is hidden
  uint32_t first_sample = 0;
  uint32_t first_row = 0;
};

class SampleSum {
 public:
  // light        HasUnequalSamples
  // total        samples in all, of which each call gets some
  // sums_all     also add up what samples send that are hidden
  SampleSum(const AreaLight& light, const ReceiverPatch& receiver, double surface_offset,
            uint32_t total, bool sums_all);

  // Adds `samples` to the rows of `window`, each texel's in the order of the samples: the bits do
  // not depend on threads, bands or calls. Samples within surface_offset of the receiver's plane
  // send nothing, nor do those behind a receiver that is lit from its front alone.
  //
  // Once `stop` is requested, which is asked every 16 rows, the sums are of no use.
  //
  // Cost  O(samples · texels), 8 operations each on as many lanes as there are
  void AddBand(std::span<const LightSample> samples, const TexelWindow& window,
               const BandShadows& hidden, const BandShadows& hidden_too,
               const std::stop_token& stop);

  std::span<const float> Visible(uint32_t row) const { return Row(visible_, row); }
  // Only with `sums_all`.
  std::span<const float> All(uint32_t row) const { return Row(all_, row); }

 private:
  // A sample in the frame of the receiver: x along edge_u, y across it in the plane, z the normal.
  struct Sample {
    DVec3 place{0.0};   // from the receiver's origin
    DVec3 facing{0.0};  // unit normal of the light there
    double weight = 0;  // a |z| / π; 0: sends nothing
  };

  Sample Prepare(const LightSample& sample) const;
  TermRow RowOf(const Sample& sample, uint32_t row) const;
  std::span<const float> Row(const std::vector<float>& sums, uint32_t row) const {
    return std::span(sums).subspan(size_t{row} * stride_, receiver_.width);
  }

  const AreaLight light_;
  const ReceiverPatch receiver_;
  const double surface_offset_;
  const uint32_t total_;
  const uint32_t stride_;  // floats a row
  DVec3 x_, y_, z_;        // axes of the frame
  TermRule rule_;
  std::vector<float> visible_, all_;
};

}  // namespace penumbra
