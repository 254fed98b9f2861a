// image_io.h and deep_exr.h, by the module of image_module.h.

#include <dlfcn.h>

#include <string>
#include <system_error>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/display/deep_exr.h"
#include "client/display/image_io.h"
#include "client/display/image_module.h"

namespace penumbra {
namespace {

// Beside the program, or where it was built: nowhere that others might put one.
absl::StatusOr<const ImageModule*> Load() {
  const std::filesystem::path built = PENUMBRA_IMAGE_MODULE;
  std::error_code ignored;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", ignored);
  std::string why;
  for (const auto& path : {program.parent_path() / built.filename(), built}) {
    if (!std::filesystem::exists(path, ignored)) continue;
    // Never closed: what it brought along may have started threads.
    void* const module = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    const void* const symbol = module ? dlsym(module, kImageModuleSymbol) : nullptr;
    if (symbol != nullptr) return static_cast<const ImageModule*>(symbol);
    why = dlerror();
  }
  if (why.empty()) why = absl::StrCat("there is no ", built.filename().string());
  return absl::UnavailableError(absl::StrCat("image files: ", why));
}

absl::StatusOr<const ImageModule*> Module() {
  static const auto* const module = new absl::StatusOr<const ImageModule*>(Load());
  return *module;
}

}  // namespace

absl::Status WritePng(const std::filesystem::path& path, int width, int height,
                      std::span<const uint8_t> rgb) {
  const auto module = Module();
  return module.ok() ? (*module)->write_png(path, width, height, rgb) : module.status();
}

absl::Status WriteExr(const std::filesystem::path& path, int width, int height,
                      std::span<const NamedPlane> planes) {
  const auto module = Module();
  return module.ok() ? (*module)->write_exr(path, width, height, planes) : module.status();
}

absl::Status WriteExr(const std::filesystem::path& path, const Picture& picture) {
  std::vector<float> channels[4];
  std::vector<NamedPlane> planes;
  for (int c = 0; c < 4; ++c) {
    for (const Vec4& pixel : picture.pixels) channels[c].push_back(pixel[c]);
    planes.push_back({std::string(1, "RGBA"[c]), channels[c]});
  }
  return WriteExr(path, picture.width, picture.height, planes);
}

absl::StatusOr<Planes> ReadImage(const std::filesystem::path& path) {
  const auto module = Module();
  if (!module.ok()) return module.status();
  return (*module)->read_image(path);
}

absl::Status WriteDeepExr(const std::filesystem::path& path, const AttenuationLdi& ldi) {
  const auto module = Module();
  return module.ok() ? (*module)->write_deep_exr(path, ldi) : module.status();
}

absl::StatusOr<AttenuationLdi> ReadDeepExr(const std::filesystem::path& path) {
  const auto module = Module();
  if (!module.ok()) return module.status();
  return (*module)->read_deep_exr(path);
}

}  // namespace penumbra
