#include "render/technique/soft_texture/receiver_coverage.h"

namespace penumbra {

ReceiverCoverage::ReceiverCoverage(const ReceiverPatch& receiver) {
  if (receiver.region == nullptr) return;
  mask_ = CoverRegion(*receiver.region, receiver.width, receiver.height);
  if (mask_ != nullptr) gutter_ = FindGutter(*mask_, kReach);
}

void ReceiverCoverage::FillOutside(std::vector<uint16_t>& counts) const {
  if (mask_ == nullptr) return;
  for (size_t k = 0; k < counts.size(); ++k) {
    if (!mask_->At(k)) counts[k] = 0;
  }
  for (const GutterTexel& texel : gutter_) counts[texel.outside] = counts[texel.inside];
}

}  // namespace penumbra
