#include "proto/convert/coverage_codec.h"

#include <algorithm>
#include <span>
#include <string>

#include "proto/convert/plane_codec.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

// A mask is sent once.
constexpr int kZstdLevel = 1;

template <typename Byte>
std::span<Byte> PartOf(std::span<Byte> bytes, uint32_t index) {
  const size_t begin = index * kCoveragePartBytes;
  return bytes.subspan(begin, std::min(kCoveragePartBytes, bytes.size() - begin));
}

std::span<const char> CharsOf(std::span<const uint8_t> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
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
  part.set_codec(PlanePacker(kZstdLevel).Pack(CharsOf(plain), *part.mutable_bits()));
  return part;
}

absl::Status DecodePart(const v1::CoveragePart& part, CoverageMask& mask) {
  if (part.index() >= CoveragePartCount(mask)) {
    return Invalid("RANGE", "found part " + std::to_string(part.index()) + ", need less than " +
                                std::to_string(CoveragePartCount(mask)));
  }
  const auto plain = PartOf(mask.mutable_bytes(), part.index());
  PlaneUnpacker unpacker;
  const auto found = unpacker.Unpack(part.codec(), part.bits(), plain.size(), "coverage");
  if (!found.ok()) return found.status();
  std::ranges::copy(*found, plain.begin());
  const size_t used_bits = mask.texel_count() % 8;
  if (used_bits != 0 && mask.bytes().back() >> used_bits != 0) {
    return Invalid("RANGE", "found bits past the last texel, need 0");
  }
  return absl::OkStatus();
}

}  // namespace penumbra
