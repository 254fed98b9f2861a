// What files show of a shadow-width map.
#pragma once

#include <filesystem>

#include "absl/status/status.h"
#include "render/artifact/radiance_format.h"
#include "render/artifact/shadow_texels.h"
#include "render/artifact/shadow_width_map.h"

namespace penumbra {

// How far each texel is from one that is lit, in texels, grey: 0 where it is lit itself, or none
// is; faces one below the other.
RadianceTexture PictureOf(const ShadowWidthMap& map);

// All planes as channels of an EXR file, faces one below the other: depth and width, and with a
// second layer far.depth and far.width.
absl::Status WriteNumbers(const std::filesystem::path& path, const ShadowWidthMap& map,
                          const RadianceTexture& picture);

}  // namespace penumbra
