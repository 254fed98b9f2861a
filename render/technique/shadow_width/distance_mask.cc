#include "render/technique/shadow_width/distance_mask.h"

#include "absl/strings/str_cat.h"

namespace penumbra {

absl::Status CheckMask(const BlockedMask& mask) {
  if (mask.width < 1 || mask.height < 1 || mask.width > kMaxMaskSide ||
      mask.height > kMaxMaskSide) {
    return absl::InvalidArgumentError(absl::StrCat("mask: found ", mask.width, " × ", mask.height,
                                                   " texels, need sides of 1 to ", kMaxMaskSide));
  }
  const size_t needed = size_t{mask.width} * mask.height;
  if (mask.blocked.size() != needed) {
    return absl::InvalidArgumentError(
        absl::StrCat("mask.blocked: found ", mask.blocked.size(), " texels, need ", needed));
  }
  return absl::OkStatus();
}

}  // namespace penumbra
