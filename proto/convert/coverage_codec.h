// Coverage masks in parts of 64 KiB, packed and unpacked without loss.
//
//   for (uint32_t i = 0; i < CoveragePartCount(mask); ++i) Send(EncodePart(mask, i));
//   absl::Status status = DecodePart(part, mask_of_the_same_size);
#pragma once

#include <cstddef>
#include <cstdint>

#include "absl/status/status.h"
#include "penumbra/v1/artifact.pb.h"
#include "render/scene/coverage_mask.h"

namespace penumbra {

inline constexpr size_t kCoveragePartBytes = 65'536;  // before packing

size_t CoveragePartCount(const CoverageMask& mask);

// Whether a part is the same in two masks of one size.
bool CoveragePartsEqual(const CoverageMask& a, const CoverageMask& b, uint32_t index);

v1::CoveragePart EncodePart(const CoverageMask& mask, uint32_t index);

// Writes a part into `mask`, whose size is set.
//
// Errors  kInvalidArgument RANGE: no such part, or bits past the last texel; CODEC; LENGTH
absl::Status DecodePart(const v1::CoveragePart& part, CoverageMask& mask);

}  // namespace penumbra
