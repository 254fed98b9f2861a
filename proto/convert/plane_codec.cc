#include "proto/convert/plane_codec.h"

#include <zstd.h>

#include <algorithm>

#include "render/scene/field_error.h"

namespace penumbra {
namespace {

absl::Status Invalid(const char* reason, const char* field, const std::string& text) {
  return FieldError(absl::StatusCode::kInvalidArgument, reason, field, text);
}

}  // namespace

PlanePacker::PlanePacker(int level) : level_(level), zstd_(ZSTD_createCCtx(), &ZSTD_freeCCtx) {}

v1::Codec PlanePacker::Pack(std::span<const char> plane, std::string& packed) {
  packed.resize(plane.size());
  // No room for more than the plane itself: an error means that it would not shrink.
  const size_t size = ZSTD_compressCCtx(zstd_.get(), packed.data(), packed.size(), plane.data(),
                                        plane.size(), level_);
  if (ZSTD_isError(size) || size >= plane.size()) {
    packed.assign(plane.data(), plane.size());
    return v1::CODEC_RAW;
  }
  packed.resize(size);
  return v1::CODEC_ZSTD;
}

PlaneUnpacker::PlaneUnpacker() : zstd_(ZSTD_createDCtx(), &ZSTD_freeDCtx) {}

absl::StatusOr<std::span<const char>> PlaneUnpacker::Unpack(v1::Codec codec,
                                                            const std::string& packed, size_t size,
                                                            const char* field) {
  size_t found = packed.size();
  plane_.resize(size);
  if (codec == v1::CODEC_ZSTD) {
    found = ZSTD_decompressDCtx(zstd_.get(), plane_.data(), size, packed.data(), packed.size());
    if (ZSTD_isError(found)) {
      return Invalid("CODEC", field,
                     std::string("found ") + ZSTD_getErrorName(found) +
                         ", need a Zstandard frame of " + std::to_string(size) + " bytes");
    }
  } else if (codec == v1::CODEC_RAW) {
    if (found == size) std::copy(packed.begin(), packed.end(), plane_.begin());
  } else {
    return Invalid("CODEC", field, "found codec " + std::to_string(codec) + ", need raw or zstd");
  }
  if (found == size) return plane_;
  return Invalid("LENGTH", field,
                 "found " + std::to_string(found) + " bytes, need " + std::to_string(size));
}

}  // namespace penumbra
