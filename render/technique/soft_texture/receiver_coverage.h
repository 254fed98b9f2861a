// The texels of a receiver that does not fill its patch.
//
//   const ReceiverCoverage coverage(receiver);
//   coverage.FillOutside(counts);           // of each pass
//   texture.coverage = coverage.mask();
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "render/scene/coverage_mask.h"
#include "render/scene/receiver.h"

namespace penumbra {

class ReceiverCoverage {
 public:
  // How far outside a texel still repeats one inside, in texels: enough for any filter of a few
  // texels, and for the tips of corners of 4° or more, which hold no texel's centre.
  static constexpr int kReach = 16;

  explicit ReceiverCoverage(const ReceiverPatch& receiver);

  // Null: every texel is inside.
  const std::shared_ptr<const CoverageMask>& mask() const { return mask_; }

  // Sets the counts outside: to that of the nearest texel inside where it lies within kReach, to 0
  // further off.
  void FillOutside(std::vector<uint16_t>& counts) const;

 private:
  std::shared_ptr<const CoverageMask> mask_;
  std::vector<GutterTexel> gutter_;
};

// What the mask says already, and would be held for as long as the artifact.
inline ReceiverPatch WithoutRegion(ReceiverPatch receiver) {
  receiver.region = nullptr;
  return receiver;
}

}  // namespace penumbra
