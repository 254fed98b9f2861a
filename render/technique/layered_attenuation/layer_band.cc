#include "render/technique/layered_attenuation/layer_band.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace penumbra {
namespace {

// What no map has in its window.
constexpr float kNowhere = std::numeric_limits<float>::quiet_NaN();

float SlackOf(float nearness, float gradient_x, float gradient_y, const LayerTolerance& tolerance,
              bool from_infinity) {
  const float width = from_infinity ? tolerance.width : tolerance.width * nearness;
  return tolerance.pixels * (width + std::abs(gradient_x) + std::abs(gradient_y));
}

}  // namespace

LayerBand::LayerBand(uint32_t width, uint32_t first_row, uint32_t rows)
    : width_(width), first_row_(first_row), rows_(rows), heads_(size_t{width} * rows, kNone) {}

size_t LayerBand::bytes() const {
  return heads_.size() * sizeof(uint32_t) + counts_.size() * kBytesPerLayer;
}

void LayerBand::Grow() {
  // At first as many as there are pixels, then an eighth more; whole vectors may be read past the
  // end.
  const size_t room =
      counts_.empty() ? heads_.size() + kLayerLanes : counts_.size() + counts_.size() / 8 + 1;
  x_.resize(room, kNowhere);
  for (std::vector<float>* v : {&y_, &nearness_, &gradient_x_, &gradient_y_}) v->resize(room);
  counts_.resize(room);
  nexts_.resize(room, kNone);
}

LayerBand::Found LayerBand::Add(const PixelSurface& surface, const LayerTolerance& tolerance,
                                bool from_infinity, uint32_t most) {
  const ImagePlane& p = surface.plane;
  const float slack = SlackOf(p.nearness, p.gradient.x, p.gradient.y, tolerance, from_infinity);
  uint32_t* link = &heads_[size_t{surface.row - first_row_} * width_ + surface.column];
  uint32_t others = 0;
  while (*link != kNone) {
    const uint32_t k = *link;
    if (std::abs(nearness_[k] - p.nearness) <= slack) return Found::kKnown;
    if (++others == most) return Found::kTooMany;
    link = &nexts_[k];
  }
  const size_t k = size_++;
  *link = static_cast<uint32_t>(k);
  if (size_ + kLayerLanes > counts_.size()) Grow();
  x_[k] = p.at.x;
  y_[k] = p.at.y;
  nearness_[k] = p.nearness;
  gradient_x_[k] = p.gradient.x;
  gradient_y_[k] = p.gradient.y;
  counts_[k] = 0;  // vectors that reach past the end have counted there
  return Found::kNew;
}

LayerArrays LayerBand::LayersFrom(size_t first) {
  return {.x = x_.data() + first,
          .y = y_.data() + first,
          .nearness = nearness_.data() + first,
          .gradient_x = gradient_x_.data() + first,
          .gradient_y = gradient_y_.data() + first,
          .count = counts_.data() + first,
          .size = size_ - first};
}

void LayerBand::Append(bool from_infinity, uint16_t unhidden, LdiFace& face) const {
  std::vector<std::pair<float, uint16_t>> layers;
  for (const uint32_t head : heads_) {
    face.offsets.push_back(static_cast<uint32_t>(face.depths.size()));
    layers.clear();
    for (uint32_t k = head; k != kNone; k = nexts_[k]) {
      const float depth = from_infinity ? -nearness_[k] : 1 / nearness_[k];
      layers.emplace_back(depth, static_cast<uint16_t>(counts_[k] + unhidden));
    }
    if (layers.size() > 1) std::ranges::sort(layers);
    for (const auto& [depth, count] : layers) {
      face.depths.push_back(depth);
      face.counts.push_back(count);
    }
  }
}

}  // namespace penumbra
