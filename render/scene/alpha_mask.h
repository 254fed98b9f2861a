// An image of opacities that cuts holes into an instance: leaves, fences, lace.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "render/math/vec.h"
#include "render/scene/content_hash.h"
#include "render/scene/scene_limits.h"

namespace penumbra {

// H×W opacities, 0 clear … 255 opaque, row 0 at v = 0, repeated outside [0, 1)².
class AlphaMask {
 public:
  // Errors  kInvalidArgument: a side is 0 or too long, or `alpha` is not width·height long.
  static absl::StatusOr<std::shared_ptr<const AlphaMask>> Create(uint32_t width, uint32_t height,
                                                                 std::vector<uint8_t> alpha,
                                                                 const SceneLimits& limits = {});

  const ContentHash& id() const { return id_; }
  uint32_t width() const { return width_; }
  uint32_t height() const { return height_; }
  std::span<const uint8_t> alpha() const { return alpha_; }

  // The opacity, in [0, 1], of the texel that holds `uv` (nearest, repeating).
  float At(Vec2 uv) const;

 private:
  AlphaMask() = default;

  uint32_t width_ = 0;
  uint32_t height_ = 0;
  std::vector<uint8_t> alpha_;
  ContentHash id_;
};

}  // namespace penumbra
