// Where image files are read and written: a module that is loaded when the first one is. It takes
// OpenImageIO, whose 260 libraries take a program 0.4 s to start, and most commands need no image.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/display/deep_exr.h"
#include "client/display/image_io.h"

namespace penumbra {

// As image_io.h and deep_exr.h say of the functions of these names.
struct ImageModule {
  absl::Status (*write_png)(const std::filesystem::path&, int, int, std::span<const uint8_t>);
  absl::Status (*write_exr)(const std::filesystem::path&, int, int, std::span<const NamedPlane>);
  absl::StatusOr<Planes> (*read_image)(const std::filesystem::path&);
  absl::Status (*write_deep_exr)(const std::filesystem::path&, const AttenuationLdi&);
  absl::StatusOr<AttenuationLdi> (*read_deep_exr)(const std::filesystem::path&);
};

// The name of the module's one symbol, a `const ImageModule`.
inline constexpr char kImageModuleSymbol[] = "penumbra_image_module";

}  // namespace penumbra
