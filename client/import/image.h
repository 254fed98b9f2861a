// Decodes the textures of a scene file as far as shadows need them: mean colour and opacity.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "render/math/vec.h"
#include "render/scene/scene_limits.h"

namespace penumbra {

// H×W texels of RGBA, row 0 the topmost; colour in sRGB, opacity linear.
struct Image {
  uint32_t width = 0;
  uint32_t height = 0;
  std::vector<uint8_t> rgba;
};

// Reads PNG, JPEG and the other formats that stb knows.
//
// Errors  kInvalidArgument, IMAGE_FORMAT; kResourceExhausted, IMAGE_SIZE: over max_mask_side, or
// more
//         texels than a file of so many bytes can hold, found before anything is allocated
absl::StatusOr<Image> DecodeImage(std::span<const std::byte> bytes, std::string_view field_path,
                                  const SceneLimits& limits = {});

// The mean colour in linear RGB, each texel weighted by its opacity; white when all is clear.
Vec3 MeanLinearColor(const Image& image);

// The image's opacities; `clear` counts the texels that are not fully opaque.
struct Opacity {
  std::vector<uint8_t> alpha;
  size_t clear = 0;
};
Opacity OpacityOf(const Image& image);

}  // namespace penumbra
