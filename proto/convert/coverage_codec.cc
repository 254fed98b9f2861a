#include "proto/convert/coverage_codec.h"

#include <zstd.h>

#include <algorithm>
#include <span>
#include <string>

#include "render/scene/field_error.h"

namespace penumbra {
namespace {

// As for tiles: a mask is sent once, and what is saved by packing harder is waited for.
constexpr int kZstdLevel = 1;

template <typename Byte>
std::span<Byte> PartOf(std::span<Byte> bytes, uint32_t index) {
  const size_t begin = index * kCoveragePartBytes;
  return bytes.subspan(begin, std::min(kCoveragePartBytes, bytes.size() - begin));
}

absl::Status Invalid(const char* reason, const std::string& text) {
  return FieldError(absl::StatusCode::kInvalidArgument, reason, "coverage", text);
}

}  // namespace

size_t CoveragePartCount(const CoverageMask& mask) {
  return (mask.bytes().size() + kCoveragePartBytes - 1) / kCoveragePartBytes;
}

bool CoveragePartsEqual(const CoverageMask& a, const CoverageMask& b, uint32_t index) {
  return std::ranges::equal(PartOf(a.bytes(), index), PartOf(b.bytes(), index));
}

v1::CoveragePart EncodePart(const CoverageMask& mask, uint32_t index) {
  v1::CoveragePart part;
  part.set_index(index);
  const auto plain = PartOf(mask.bytes(), index);
  std::string& bits = *part.mutable_bits();
  bits.resize(plain.size());
  // No room for more than the part itself: an error means that it would not shrink.
  const size_t size =
      ZSTD_compress(bits.data(), bits.size(), plain.data(), plain.size(), kZstdLevel);
  if (ZSTD_isError(size) || size >= plain.size()) {
    bits.assign(plain.begin(), plain.end());
    part.set_codec(v1::CODEC_RAW);
  } else {
    bits.resize(size);
    part.set_codec(v1::CODEC_ZSTD);
  }
  return part;
}

absl::Status DecodePart(const v1::CoveragePart& part, CoverageMask& mask) {
  if (part.index() >= CoveragePartCount(mask)) {
    return Invalid("RANGE", "found part " + std::to_string(part.index()) + ", need less than " +
                                std::to_string(CoveragePartCount(mask)));
  }
  const auto plain = PartOf(mask.mutable_bytes(), part.index());
  const std::string& bits = part.bits();
  size_t found = bits.size();
  if (part.codec() == v1::CODEC_ZSTD) {
    found = ZSTD_decompress(plain.data(), plain.size(), bits.data(), bits.size());
    if (ZSTD_isError(found)) {
      return Invalid("CODEC", std::string("found ") + ZSTD_getErrorName(found) +
                                  ", need a Zstandard frame of " + std::to_string(plain.size()) +
                                  " bytes");
    }
  } else if (part.codec() == v1::CODEC_RAW) {
    if (found == plain.size()) std::copy(bits.begin(), bits.end(), plain.begin());
  } else {
    return Invalid("CODEC", "found codec " + std::to_string(part.codec()) + ", need raw or zstd");
  }
  if (found != plain.size()) {
    return Invalid("LENGTH", "found " + std::to_string(found) + " bytes, need " +
                                 std::to_string(plain.size()));
  }
  const size_t used_bits = mask.texel_count() % 8;
  if (used_bits != 0 && mask.bytes().back() >> used_bits != 0) {
    return Invalid("RANGE", "found bits past the last texel, need 0");
  }
  return absl::OkStatus();
}

}  // namespace penumbra
