#include "render/scene/alpha_mask.h"

#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/scene/blob.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

// The texel of `count` that holds coordinate `t`, repeating.
uint32_t RepeatedTexel(float t, uint32_t count) {
  const float wrapped = t - std::floor(t);
  if (!(wrapped >= 0)) return 0;  // `t` is not finite
  const auto texel = static_cast<uint32_t>(wrapped * static_cast<float>(count));
  return texel < count ? texel : count - 1;
}

}  // namespace

absl::StatusOr<std::shared_ptr<const AlphaMask>> AlphaMask::Create(uint32_t width, uint32_t height,
                                                                   std::vector<uint8_t> alpha,
                                                                   const SceneLimits& limits) {
  for (const auto& [name, side] : {std::pair{"width", width}, std::pair{"height", height}}) {
    if (side == 0 || side > limits.max_mask_side) {
      return FieldError(absl::StatusCode::kInvalidArgument, "IMAGE_SIZE", name,
                        absl::StrCat("found ", side, ", need 1 to ", limits.max_mask_side));
    }
  }
  const uint64_t texels = uint64_t{width} * height;
  if (alpha.size() != texels) {
    return FieldError(absl::StatusCode::kInvalidArgument, "LENGTH", "alpha",
                      absl::StrCat("found ", alpha.size(), " bytes, need ", texels));
  }
  std::shared_ptr<AlphaMask> mask(new AlphaMask);
  mask->width_ = width;
  mask->height_ = height;
  mask->alpha_ = std::move(alpha);
  mask->id_ = Sha256(EncodeBlob(*mask));
  return mask;
}

float AlphaMask::At(Vec2 uv) const {
  const uint32_t i = RepeatedTexel(uv.x, width_);
  const uint32_t j = RepeatedTexel(uv.y, height_);
  return static_cast<float>(alpha_[size_t{j} * width_ + i]) / 255.0f;
}

}  // namespace penumbra
