#include "client/import/image.h"

#include <stb_image.h>

#include <algorithm>
#include <array>
#include <climits>
#include <cmath>
#include <memory>

#include "absl/strings/str_cat.h"
#include "client/import/source_file.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

// Deflate expands by at most 1032, and a one-bit image packs 8 texels into a byte.
constexpr uint64_t kMaxTexelsPerByte = 8 * 1032;
// 256 MiB of RGBA.
constexpr uint64_t kMaxTexels = uint64_t{1} << 26;

// IEC 61966-2-1.
double LinearFromSrgb(uint8_t code) {
  const double c = code / 255.0;
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

std::array<double, 256> LinearTable() {
  std::array<double, 256> table{};
  for (int i = 0; i < 256; ++i) table[i] = LinearFromSrgb(static_cast<uint8_t>(i));
  return table;
}

}  // namespace

absl::StatusOr<Image> DecodeImage(std::span<const std::byte> bytes, std::string_view field_path,
                                  const SceneLimits& limits) {
  int width = 0, height = 0, channels = 0;
  const auto* data = reinterpret_cast<const stbi_uc*>(bytes.data());
  if (bytes.empty() || bytes.size() > INT_MAX ||
      !stbi_info_from_memory(data, static_cast<int>(bytes.size()), &width, &height, &channels) ||
      width <= 0 || height <= 0) {
    return Malformed("IMAGE_FORMAT", field_path, "found no image known, need PNG or JPEG");
  }
  const uint64_t texels = uint64_t(width) * uint64_t(height);
  if (std::max(width, height) > int64_t{limits.max_mask_side} || texels > kMaxTexels ||
      texels > kMaxTexelsPerByte * bytes.size()) {
    return FieldError(absl::StatusCode::kResourceExhausted, "IMAGE_SIZE", field_path,
                      absl::StrCat("found ", width, "×", height, " texels in ", bytes.size(),
                                   " bytes, need sides <= ", limits.max_mask_side,
                                   " and <= ", kMaxTexels, " texels"));
  }
  const std::unique_ptr<stbi_uc, void (*)(void*)> decoded(
      stbi_load_from_memory(data, static_cast<int>(bytes.size()), &width, &height, &channels, 4),
      stbi_image_free);
  if (!decoded || uint64_t(width) * uint64_t(height) != texels) {
    return Malformed("IMAGE_FORMAT", field_path, "found a damaged image, need a whole one");
  }
  return Image{.width = static_cast<uint32_t>(width),
               .height = static_cast<uint32_t>(height),
               .rgba = {decoded.get(), decoded.get() + 4 * texels}};
}

Vec3 MeanLinearColor(const Image& image) {
  static const std::array<double, 256> kLinear = LinearTable();
  DVec3 sum(0.0);
  double weight = 0.0;
  for (size_t i = 0; i + 3 < image.rgba.size(); i += 4) {
    const double alpha = image.rgba[i + 3];
    sum += alpha *
           DVec3(kLinear[image.rgba[i]], kLinear[image.rgba[i + 1]], kLinear[image.rgba[i + 2]]);
    weight += alpha;
  }
  return weight > 0.0 ? Vec3(sum / weight) : Vec3(1.0f);
}

Opacity OpacityOf(const Image& image) {
  Opacity opacity;
  opacity.alpha.reserve(image.rgba.size() / 4);
  for (size_t i = 3; i < image.rgba.size(); i += 4) opacity.alpha.push_back(image.rgba[i]);
  opacity.clear = static_cast<size_t>(std::count_if(opacity.alpha.begin(), opacity.alpha.end(),
                                                    [](uint8_t a) { return a != 255; }));
  return opacity;
}

}  // namespace penumbra
