// The functions of image_io.h and deep_exr.h, as OpenImageIO does them. Only the module that is
// loaded for them (image_module.h) has these.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/display/deep_exr.h"
#include "client/display/image_io.h"

namespace penumbra::openimageio {

absl::Status WritePng(const std::filesystem::path& path, int width, int height,
                      std::span<const uint8_t> rgb);
absl::Status WriteExr(const std::filesystem::path& path, int width, int height,
                      std::span<const NamedPlane> planes);
absl::StatusOr<Planes> ReadImage(const std::filesystem::path& path);

absl::Status WriteDeepExr(const std::filesystem::path& path, const AttenuationLdi& ldi);
absl::StatusOr<AttenuationLdi> ReadDeepExr(const std::filesystem::path& path);

}  // namespace penumbra::openimageio
