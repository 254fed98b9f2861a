#include "client/cli/width_map_files.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "client/display/image_io.h"

namespace penumbra {
namespace {

struct Size {
  uint32_t width = 0, height = 0;
};

Size SizeOf(const ShadowWidthMap& map) {
  Size size;
  for (const ShadowWidthFace& face : map.faces) {
    size.width = std::max(size.width, face.view.width);
    size.height += face.view.height;
  }
  return size;
}

// Null where the face has none.
using PlaneOf = std::function<const std::vector<float>*(const ShadowWidthFace&)>;

// Faces below each other; `missing` where there is none.
std::vector<float> Stack(const ShadowWidthMap& map, float missing, const PlaneOf& plane_of) {
  const Size size = SizeOf(map);
  std::vector<float> stacked(size_t{size.width} * size.height, missing);
  size_t row = 0;
  for (const ShadowWidthFace& face : map.faces) {
    const std::vector<float>* const plane = plane_of(face);
    for (uint32_t y = 0; y < face.view.height; ++y, ++row) {
      if (plane == nullptr) continue;
      std::copy_n(plane->data() + size_t{y} * face.view.width, face.view.width,
                  stacked.data() + row * size.width);
    }
  }
  return stacked;
}

const std::vector<float>* NearDepths(const ShadowWidthFace& face) { return &face.near.depths; }
const std::vector<float>* NearWidths(const ShadowWidthFace& face) { return &face.near.widths; }
const std::vector<float>* FarDepths(const ShadowWidthFace& face) {
  return face.far ? &face.far->depths : nullptr;
}
const std::vector<float>* FarWidths(const ShadowWidthFace& face) {
  return face.far ? &face.far->widths : nullptr;
}

}  // namespace

RadianceTexture PictureOf(const ShadowWidthMap& map) {
  const Size size = SizeOf(map);
  RadianceTexture picture{.width = size.width, .height = size.height, .texels = {}};
  picture.texels.resize(size_t{size.width} * size.height);
  size_t row = 0;
  for (const ShadowWidthFace& face : map.faces) {
    const double scale = face.view.pixels_per_slope().x;
    for (uint32_t y = 0; y < face.view.height; ++y, ++row) {
      for (uint32_t x = 0; x < face.view.width; ++x) {
        const float width = face.near.widths[size_t{y} * face.view.width + x];
        if (!std::isfinite(width)) continue;
        picture.texels[row * size.width + x] = Vec3(static_cast<float>(scale * width));
      }
    }
  }
  return picture;
}

absl::Status WriteNumbers(const std::filesystem::path& path, const ShadowWidthMap& map,
                          const RadianceTexture& picture) {
  const std::vector<float> depths = Stack(map, kNoDepth, NearDepths);
  const std::vector<float> widths = Stack(map, 0.0f, NearWidths);
  const std::vector<float> far_depths = Stack(map, kNoDepth, FarDepths);
  const std::vector<float> far_widths = Stack(map, 0.0f, FarWidths);
  std::vector<NamedPlane> channels = {{"depth", depths}, {"width", widths}};
  const bool has_far = std::ranges::any_of(
      map.faces, [](const ShadowWidthFace& face) { return face.far.has_value(); });
  if (has_far) {
    channels.insert(channels.end(), {{"far.depth", far_depths}, {"far.width", far_widths}});
  }
  return WriteExr(path, static_cast<int>(picture.width), static_cast<int>(picture.height),
                  channels);
}

}  // namespace penumbra
