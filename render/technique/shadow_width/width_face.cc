#include "render/technique/shadow_width/width_face.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>

namespace penumbra {
namespace {

// The part of a depth within which two receivers are one.
constexpr double kSameReceiver = 0x1p-10;

// Texels' widths by which the far side of a blocker is taken for nearer than it is, at most to its
// middle: what stands on a receiver touches it there, and a look-up leaves a surface out of the
// shadow of what is less than the spread of its plane before it. It has a near side of its own,
// which would be in its shadow if its far side were taken for nearer than that.
constexpr double kTouching = 6.0;

// `depth`, less so much; `near_side` is what receives last before it, or itself.
float BeforeTouching(float depth, float near_side, const LightView& view) {
  const double pixel = (view.from_infinity ? 1 : double{depth}) / view.pixels_per_slope().x;
  const double thickness = std::max(0.0, double{depth} - double{near_side});
  return static_cast<float>(depth - std::min(kTouching * pixel, 0.5 * thickness));
}

// Whether a receiver that casts is between the blocker of texel i and the last one.
bool HasTwo(const ShadowLayers& layers, const LightView& view, size_t i) {
  if (layers.first_receiver[i] == kNoDepth) return false;
  const double first = layers.first_receiver[i], last = layers.last_receiver[i];
  const double same = kSameReceiver * (view.from_infinity ? view.far - view.near : last);
  return last - first > same && layers.before_last[i] > first - same;
}

// The texels that two instances block, one above the other.
struct Pair {
  uint32_t first, last;

  friend auto operator<=>(const Pair&, const Pair&) = default;
};
struct Box {
  uint32_t min_x = ~0u, min_y = ~0u, max_x = 0, max_y = 0;

  void Add(uint32_t x, uint32_t y) {
    min_x = std::min(min_x, x), max_x = std::max(max_x, x);
    min_y = std::min(min_y, y), max_y = std::max(max_y, y);
  }
  // With a texel around, as far as the view goes.
  Box Grown(const LightView& view) const {
    return {min_x - (min_x > 0), min_y - (min_y > 0), std::min(max_x + 1, view.width - 1),
            std::min(max_y + 1, view.height - 1)};
  }
  uint32_t width() const { return max_x - min_x + 1; }
  uint32_t height() const { return max_y - min_y + 1; }
};

// Both layers of a face in the making.
class TwoLayers {
 public:
  TwoLayers(ShadowWidthFace& face, const ShadowLayers& layers, const FindDistances& find_distances)
      : face_(face), view_(face.view), layers_(layers), find_distances_(find_distances) {}

  // Gives the face its second layer, if any texel has one.
  absl::Status Add() {
    const size_t texels = layers_.blocked.size();
    ShadowWidthLayer far{.depths = std::vector<float>(texels, kNoDepth),
                         .widths = std::vector<float>(texels)};
    std::map<Pair, Box> pairs;
    has_two_.resize(texels);
    for (uint32_t y = 0; y < view_.height; ++y) {
      for (uint32_t x = 0; x < view_.width; ++x) {
        const size_t i = At(x, y);
        if (!HasTwo(layers_, view_, i)) continue;
        has_two_[i] = 1;
        far.depths[i] = BeforeTouching(layers_.before_last[i], layers_.receiver_at_last[i], view_);
        far.widths[i] = face_.near.widths[i];
        pairs[{layers_.first_blocker[i], layers_.last_blocker[i]}].Add(x, y);
      }
    }
    if (pairs.empty()) return absl::OkStatus();
    face_.far = std::move(far);
    for (const auto& [pair, box] : pairs) {
      if (pair.first == pair.last) continue;
      absl::Status status = Part(pair, box.Grown(view_), pair.last, face_.near.widths);
      if (status.ok()) status = Part(pair, box.Grown(view_), pair.first, face_.far->widths);
      if (!status.ok()) return status;
    }
    return absl::OkStatus();
  }

 private:
  size_t At(uint32_t x, uint32_t y) const { return size_t{y} * view_.width + x; }
  bool IsOf(size_t i, const Pair& pair) const {
    return has_two_[i] != 0 && Pair{layers_.first_blocker[i], layers_.last_blocker[i]} == pair;
  }

  // Where the pair is, widths end at texels that `other` alone blocks.
  absl::Status Part(const Pair& pair, const Box& box, uint32_t other, std::vector<float>& widths) {
    std::vector<uint8_t> blocked(size_t{box.width()} * box.height(), 1);
    bool any = false;
    for (uint32_t y = box.min_y; y <= box.max_y; ++y) {
      for (uint32_t x = box.min_x; x <= box.max_x; ++x) {
        const size_t i = At(x, y);
        if (has_two_[i] != 0 || layers_.first_blocker[i] != other) continue;
        blocked[InBox(box, x, y)] = 0;
        any = true;
      }
    }
    if (!any) return absl::OkStatus();
    const auto distances =
        find_distances_({.blocked = blocked, .width = box.width(), .height = box.height()});
    if (!distances.ok()) return distances.status();
    const auto pixel = static_cast<float>(1 / view_.pixels_per_slope().x);
    for (uint32_t y = box.min_y; y <= box.max_y; ++y) {
      for (uint32_t x = box.min_x; x <= box.max_x; ++x) {
        if (!IsOf(At(x, y), pair)) continue;
        float& width = widths[At(x, y)];
        width = std::min(width, pixel * (*distances)[InBox(box, x, y)]);
      }
    }
    return absl::OkStatus();
  }
  static size_t InBox(const Box& box, uint32_t x, uint32_t y) {
    return size_t{y - box.min_y} * box.width() + (x - box.min_x);
  }

  ShadowWidthFace& face_;
  const LightView& view_;
  const ShadowLayers& layers_;
  const FindDistances& find_distances_;
  std::vector<uint8_t> has_two_;
};

}  // namespace

absl::StatusOr<ShadowWidthFace> MakeWidthFace(const DepthMap& nearest, const ShadowLayers& layers,
                                              const ShadowWidthParams& params,
                                              const FindDistances& find_distances) {
  const LightView& view = nearest.view;
  const size_t texels = nearest.depths.size();
  auto widths =
      find_distances({.blocked = layers.blocked, .width = view.width, .height = view.height});
  if (!widths.ok()) return widths.status();
  const auto pixel = static_cast<float>(1 / view.pixels_per_slope().x);
  for (float& width : *widths) width *= pixel;
  ShadowWidthFace face{.view = view, .window = view.window};
  face.near = {.depths = std::vector<float>(texels, kNoDepth), .widths = *std::move(widths)};
  const bool has_two = params.layers > 1;
  const auto& far_sides = has_two ? layers.before_first : layers.before_last;
  const auto& near_sides = has_two ? nearest.depths : layers.receiver_at_last;
  for (size_t i = 0; i < texels; ++i) {
    if (layers.blocked[i] == 0) continue;
    face.near.depths[i] = params.blocker_depth == BlockerDepth::kNearest
                              ? nearest.depths[i]
                              : BeforeTouching(far_sides[i], near_sides[i], view);
  }
  if (has_two) {
    const auto status = TwoLayers(face, layers, find_distances).Add();
    if (!status.ok()) return status;
  }
  return face;
}

}  // namespace penumbra
