#include "client/display/shadow_words.h"

#include <bit>
#include <cmath>
#include <span>
#include <variant>

#include "render/artifact/light_width.h"
#include "render/scene/camera.h"
#include "render/scene/unoccluded_light.h"

namespace penumbra {
namespace {

uint32_t Size(const std::vector<uint32_t>& words) { return static_cast<uint32_t>(words.size()); }

void AppendCounts(const std::vector<uint16_t>& counts, std::vector<uint32_t>& words) {
  for (size_t i = 0; i < counts.size(); i += 2) {
    const uint32_t high = i + 1 < counts.size() ? counts[i + 1] : 0u;
    words.push_back(counts[i] | high << 16);
  }
}

// From clip space, y up, to pixels of the part, y down.
DMat4 PixelFromClip(const PicturePixels& picture) {
  const PixelRect part = picture.part();
  DMat4 pixel(1.0);
  pixel[0][0] = 0.5 * picture.width;
  pixel[3][0] = 0.5 * picture.width - part.x;
  pixel[1][1] = -0.5 * picture.height;
  pixel[3][1] = 0.5 * picture.height - part.y;
  return pixel;
}

// Of pixel i: what is reflected of the light's strength, or without radiance the share of the light
// that is seen.
class PixelValue {
 public:
  explicit PixelValue(const ViewShadow& view) : view_(view) {
    const Vec3 strength = LightStrength(view.light);
    for (int c = 1; c < 3; ++c) {
      if (strength[c] > strength[channel_]) channel_ = c;
    }
    strength_ = strength[channel_];
  }

  bool is_share() const { return !view_.radiance || !(strength_ > 0); }
  float At(size_t i) const {
    if (view_.coverage && !view_.coverage->At(i)) return -1.0f;
    if (!is_share()) return view_.radiance->texels[i][channel_] / strength_;
    const VisibilityMap& map = view_.visibility;
    return map.sample_count == 0 ? 1.0f : static_cast<float>(map.counts[i]) / map.sample_count;
  }

 private:
  const ViewShadow& view_;
  int channel_ = 0;
  float strength_ = 0.0f;
};

GpuLightFace FaceOf(const LightView& view) {
  return {.origin = Vec4(Vec3(view.frame.origin), view.from_infinity ? 1.0f : 0.0f),
          .axis_s = Vec4(Vec3(view.frame.axes.s), 0),
          .axis_t = Vec4(Vec3(view.frame.axes.t), 0),
          .axis_n = Vec4(Vec3(view.frame.axes.n), 0),
          .window = Vec4(Vec2(view.window.min), Vec2(view.pixels_per_slope())),
          .width = view.width,
          .height = view.height};
}

// Returns where they begin.
uint32_t AppendFloats(std::span<const float> floats, std::vector<uint32_t>& words) {
  const uint32_t first = Size(words);
  for (const float x : floats) words.push_back(std::bit_cast<uint32_t>(x));
  return first;
}

// The light's axes, and which texels the face tells of.
uint32_t AppendExtent(const ShadowWidthFace& face, const AreaLight& light,
                      std::vector<uint32_t>& words) {
  std::vector<float> numbers;
  const LightWidth width(light, face.view);
  for (const DVec3& axis : width.axes()) {
    for (int c = 0; c < 3; ++c) numbers.push_back(static_cast<float>(axis[c]));
  }
  for (const DVec2 corner : {face.window.min, face.window.max}) {
    const DVec2 texel = (corner - face.view.window.min) * face.view.pixels_per_slope();
    for (int c = 0; c < 2; ++c) numbers.push_back(static_cast<float>(texel[c]));
  }
  return AppendFloats(numbers, words);
}

}  // namespace

void ShadowWords::Append(const AttenuationLdi& ldi, LightShadow& shadow) {
  shadow.first_face = static_cast<uint32_t>(faces.size());
  shadow.face_count = static_cast<uint32_t>(ldi.faces.size());
  shadow.sample_count = ldi.sample_count;
  shadow.tolerance = ldi.tolerance;
  for (const LdiFace& face : ldi.faces) {
    GpuLightFace gpu = FaceOf(face.view);
    gpu.first_words[0] = Size(words);
    words.insert(words.end(), face.offsets.begin(), face.offsets.end());
    gpu.first_words[1] = AppendFloats(face.depths, words);
    gpu.first_words[2] = Size(words);
    AppendCounts(face.counts, words);
    faces.push_back(gpu);
  }
}

void ShadowWords::Append(const ShadowWidthMap& map, LightShadow& shadow) {
  shadow.first_width_face = static_cast<uint32_t>(faces.size());
  shadow.width_face_count = static_cast<uint32_t>(map.faces.size());
  shadow.c_scale = map.c_scale.value_or(-1.0f);
  shadow.c_bias = map.c_bias;
  for (const ShadowWidthFace& face : map.faces) {
    GpuLightFace gpu = FaceOf(face.view);
    gpu.first_words[0] = AppendFloats(face.near.depths, words);
    gpu.first_words[1] = AppendFloats(face.near.widths, words);
    if (face.far) {
      gpu.first_words[2] = AppendFloats(face.far->depths, words);
      gpu.first_words[3] = AppendFloats(face.far->widths, words);
    }
    gpu.first_words[4] = AppendExtent(face, map.light, words);
    faces.push_back(gpu);
  }
}

void ShadowWords::Append(const ViewShadow& view, LightShadow& shadow) {
  const auto* picture = std::get_if<PicturePixels>(&view.points);
  if (picture == nullptr) return;
  const PixelValue value(view);
  shadow.pixel_from_world =
      Mat4(PixelFromClip(*picture) * ClipFromWorld(picture->camera, picture->aspect()));
  shadow.width = view.visibility.width;
  shadow.height = view.visibility.height;
  shadow.first_word = Size(words);
  shadow.is_share = value.is_share() ? 1u : 0u;
  for (size_t i = 0; i < view.visibility.counts.size(); ++i) {
    words.push_back(std::bit_cast<uint32_t>(value.At(i)));
  }
}

}  // namespace penumbra
