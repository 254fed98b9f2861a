#include "client/cli/width_map_files.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "client/cli/stacked_faces.h"
#include "client/display/image_io.h"

namespace penumbra {
namespace {

using PlaneOf = const std::vector<float>* (*)(const ShadowWidthFace&);  // null: it has none

StackedImage Stack(const ShadowWidthMap& map, float missing, PlaneOf plane_of) {
  std::vector<StackedFace> faces;
  for (const ShadowWidthFace& face : map.faces) {
    const std::vector<float>* const plane = plane_of(face);
    faces.push_back({face.view, plane ? std::span<const float>(*plane) : std::span<const float>()});
  }
  return Stack(faces, missing);
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
  const StackedImage widths = Stack(map, 0.0f, NearWidths);
  RadianceTexture picture{.width = widths.width, .height = widths.height, .texels = {}};
  picture.texels.resize(widths.numbers.size());
  size_t row = 0;
  for (const ShadowWidthFace& face : map.faces) {
    const double scale = face.view.pixels_per_slope().x;
    const size_t end = row + face.view.height;
    for (size_t i = row * widths.width; i < end * widths.width; ++i) {
      const float width = widths.numbers[i];
      if (std::isfinite(width)) picture.texels[i] = Vec3(static_cast<float>(scale * width));
    }
    row = end;
  }
  return picture;
}

absl::Status WriteNumbers(const std::filesystem::path& path, const ShadowWidthMap& map,
                          const RadianceTexture& picture) {
  const StackedImage depths = Stack(map, kNoDepth, NearDepths);
  const StackedImage widths = Stack(map, 0.0f, NearWidths);
  const StackedImage far_depths = Stack(map, kNoDepth, FarDepths);
  const StackedImage far_widths = Stack(map, 0.0f, FarWidths);
  std::vector<NamedPlane> channels = {{"depth", depths.numbers}, {"width", widths.numbers}};
  const bool has_far = std::ranges::any_of(
      map.faces, [](const ShadowWidthFace& face) { return face.far.has_value(); });
  if (has_far) {
    channels.insert(channels.end(),
                    {{"far.depth", far_depths.numbers}, {"far.width", far_widths.numbers}});
  }
  return WriteExr(path, static_cast<int>(picture.width), static_cast<int>(picture.height),
                  channels);
}

}  // namespace penumbra
