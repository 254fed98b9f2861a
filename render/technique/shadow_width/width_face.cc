#include "render/technique/shadow_width/width_face.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "render/artifact/plane_on_image.h"

namespace penumbra {
namespace {

// Nearness that pixels' widths make of rounding to them, where no neighbour tells how steep a
// receiver is.
constexpr double kUntoldSteepness = 4.0;

// The part of a depth within which two receivers are one.
constexpr double kSameReceiver = 0x1p-10;

class FirstReceivers {
 public:
  FirstReceivers(const DepthMap& nearest, const ShadowLayers& layers)
      : view_(nearest.view), nearest_(nearest), layers_(layers) {}

  // Whether a receiver that casts is between the blocker and the last one.
  bool IsAbove(size_t i) const {
    if (layers_.first_receiver[i] == kNoDepth) return false;
    const double first = layers_.first_receiver[i], last = layers_.last_receiver[i];
    const double same = kSameReceiver * (view_.from_infinity ? view_.far - view_.near : last);
    return last - first > same && layers_.before_last[i] > first - same;
  }

  // Whether the receiver at texel i goes on at `there`, its neighbour, and is seen; `back` is the
  // one on the other side.
  bool IsSeenAt(size_t there, size_t i, std::optional<size_t> back) const {
    if (nearest_.depths[there] == kNoDepth) return true;
    const double here = Nearness(layers_.first_receiver[i]),
                 seen = Nearness(nearest_.depths[there]);
    const double pixel = 1 / view_.pixels_per_slope().x;
    double rise = 0, limit = kUntoldSteepness * pixel * (view_.from_infinity ? 1 : here);
    if (back && IsAbove(*back)) {
      const double rises = here - Nearness(layers_.first_receiver[*back]);
      if (std::abs(rises) < 4 * limit) rise = rises, limit = std::abs(rises) + 0.25 * limit;
    }
    return seen <= here + rise + limit;
  }

 private:
  double Nearness(float depth) const { return NearnessOf(view_.from_infinity, double{depth}); }

  const LightView& view_;
  const DepthMap& nearest_;
  const ShadowLayers& layers_;
};

// Left, right, above, below.
constexpr std::array<std::array<int, 2>, 4> kNeighbours = {{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};

std::optional<size_t> TexelAt(const LightView& view, int64_t x, int64_t y) {
  if (x < 0 || y < 0 || x >= view.width || y >= view.height) return std::nullopt;
  return static_cast<size_t>(y) * view.width + static_cast<size_t>(x);
}

// Distances in the window's units.
absl::StatusOr<std::vector<float>> WidthsOf(std::span<const uint8_t> blocked, const LightView& view,
                                            const FindDistances& find_distances) {
  auto widths = find_distances({.blocked = blocked, .width = view.width, .height = view.height});
  if (!widths.ok()) return widths;
  const auto pixel = static_cast<float>(1 / view.pixels_per_slope().x);
  for (float& width : *widths) width *= pixel;
  return widths;
}

// Texels' widths by which the far side of a blocker is taken for nearer than it is, at most to its
// middle: what stands on a receiver touches it there, and a look-up leaves a surface out of the
// shadow of what is less than the spread of its plane before it.
constexpr double kTouching = 6.0;

// `depth`, less so much; `near_side` is where what is there begins.
float BeforeTouching(float depth, float near_side, const LightView& view) {
  const double pixel = (view.from_infinity ? 1 : double{depth}) / view.pixels_per_slope().x;
  const double thickness = std::max(0.0, double{depth} - double{near_side});
  return static_cast<float>(depth - std::min(kTouching * pixel, 0.5 * thickness));
}

// Adds the second layer, if any receiver lies above another one, and gives the first the widths of
// such receivers.
absl::StatusOr<ShadowWidthFace> WithFarLayer(ShadowWidthFace face, const DepthMap& nearest,
                                             const ShadowLayers& layers,
                                             const FindDistances& find_distances) {
  const size_t texels = nearest.depths.size();
  const FirstReceivers receivers(nearest, layers);
  ShadowWidthLayer far{.depths = std::vector<float>(texels, kNoDepth),
                       .widths = std::vector<float>(texels)};
  bool any = false;
  for (size_t i = 0; i < texels; ++i) {
    if (!receivers.IsAbove(i)) continue;
    far.depths[i] = BeforeTouching(layers.before_last[i], layers.first_receiver[i], nearest.view);
    far.widths[i] = face.near.widths[i];
    any = true;
  }
  if (!any) return face;
  const auto blocked = BlockedForFirstReceivers(nearest, layers);
  const auto widths = WidthsOf(blocked, nearest.view, find_distances);
  if (!widths.ok()) return widths.status();
  for (size_t i = 0; i < texels; ++i) {
    if (far.depths[i] != kNoDepth) face.near.widths[i] = (*widths)[i];
  }
  face.far = std::move(far);
  return face;
}

}  // namespace

std::vector<uint8_t> BlockedForFirstReceivers(const DepthMap& nearest, const ShadowLayers& layers) {
  const LightView& view = nearest.view;
  const FirstReceivers receivers(nearest, layers);
  std::vector<uint8_t> blocked = layers.blocked;
  for (int64_t y = 0; y < view.height; ++y) {
    for (int64_t x = 0; x < view.width; ++x) {
      const size_t i = *TexelAt(view, x, y);
      if (layers.blocked[i] == 0 || !receivers.IsAbove(i)) continue;
      for (const auto& [dx, dy] : kNeighbours) {
        const auto there = TexelAt(view, x + dx, y + dy);
        if (!there || layers.blocked[*there] == 0) continue;
        if (receivers.IsSeenAt(*there, i, TexelAt(view, x - dx, y - dy))) blocked[*there] = 0;
      }
    }
  }
  return blocked;
}

absl::StatusOr<ShadowWidthFace> MakeWidthFace(const DepthMap& nearest, const ShadowLayers& layers,
                                              const ShadowWidthParams& params,
                                              const FindDistances& find_distances) {
  const LightView& view = nearest.view;
  const size_t texels = nearest.depths.size();
  auto widths = WidthsOf(layers.blocked, view, find_distances);
  if (!widths.ok()) return widths.status();
  ShadowWidthFace face{.view = view, .window = view.window};
  face.near = {.depths = std::vector<float>(texels, kNoDepth), .widths = *std::move(widths)};
  const auto& far_sides = params.layers > 1 ? layers.before_first : layers.before_last;
  for (size_t i = 0; i < texels; ++i) {
    if (layers.blocked[i] == 0) continue;
    const float near_side = nearest.depths[i];
    face.near.depths[i] = params.blocker_depth == BlockerDepth::kNearest
                              ? near_side
                              : BeforeTouching(far_sides[i], near_side, view);
  }
  if (params.layers < 2) return face;
  return WithFarLayer(std::move(face), nearest, layers, find_distances);
}

}  // namespace penumbra
