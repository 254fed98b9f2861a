#include "render/technique/coherent_raytrace/depth_pyramid.h"

#include <algorithm>
#include <cmath>

namespace penumbra {

DepthPyramid::DepthPyramid(const DepthMap& map, const GapBias& gap, bool covers_all)
    : view_(map.view), nearness_(map.view), covers_all_(covers_all) {
  if (view_.from_infinity) {
    gap_ = static_cast<float>(gap.metres.value_or(gap.pixels * PixelWidthAt(view_, 1.0)));
  } else if (gap.metres) {
    gap_ = static_cast<float>(*gap.metres);
    gap_power_ = 2;
  } else {
    gap_ = static_cast<float>(gap.relative.value_or(gap.pixels * PixelWidthAt(view_, 1.0)));
    gap_power_ = 1;
  }
  FillPixels(map);
  JoinPixels();
  while (levels_.back().width > 1 || levels_.back().height > 1) {
    levels_.push_back(Coarser(levels_.back()));
  }
}

// With n = 1/z: |z₁ − z₂| ≤ g is |n₁ − n₂| ≤ g n₁ n₂, and |z₁ − z₂| ≤ r min z is
// |n₁ − n₂| ≤ r min n.
bool DepthPyramid::AreJoined(float a, float b) const {
  if (!(a > 0 && b > 0)) return false;
  const float scale = gap_power_ == 0 ? 1.0f : gap_power_ == 1 ? std::min(a, b) : a * b;
  return std::abs(a - b) <= gap_ * scale;
}

void DepthPyramid::FillPixels(const DepthMap& map) {
  Level pixels{static_cast<int>(view_.width), static_cast<int>(view_.height), {}, {}};
  pixels.nodes.reserve(map.depths.size());
  for (const float depth : map.depths) {
    const float nearness =
        depth == kNoDepth ? 0.0f : std::max(0.0f, static_cast<float>(nearness_.Of(depth)));
    pixels.nodes.push_back({nearness, nearness});
  }
  levels_.push_back(std::move(pixels));
}

void DepthPyramid::JoinPixels() {
  Level& pixels = levels_[0];
  pixels.joined.resize(pixels.nodes.size());
  for (int y = 0; y + 1 < pixels.height; ++y) {
    const Node* const row = &pixels.nodes[static_cast<size_t>(y) * pixels.width];
    const Node* const next = row + pixels.width;
    for (int x = 0; x + 1 < pixels.width; ++x) {
      const float a = row[x].near, b = row[x + 1].near, c = next[x].near, d = next[x + 1].near;
      pixels.joined[static_cast<size_t>(y) * pixels.width + x] =
          AreJoined(a, b) && AreJoined(a, c) && AreJoined(a, d) && AreJoined(b, c) &&
          AreJoined(b, d) && AreJoined(c, d);
    }
  }
}

DepthPyramid::Level DepthPyramid::Coarser(const Level& fine) const {
  Level coarse{(fine.width + 1) / 2, (fine.height + 1) / 2, {}, {}};
  coarse.nodes.reserve(static_cast<size_t>(coarse.width) * coarse.height);
  coarse.joined.reserve(coarse.nodes.capacity());
  for (int y = 0; y < coarse.height; ++y) {
    for (int x = 0; x < coarse.width; ++x) {
      Node node = fine.nodes[static_cast<size_t>(2 * y) * fine.width + 2 * x];
      for (int k = 1; k < 4; ++k) {
        const int fx = 2 * x + k % 2, fy = 2 * y + k / 2;
        if (fx >= fine.width || fy >= fine.height) continue;
        const Node& more = fine.nodes[static_cast<size_t>(fy) * fine.width + fx];
        node = {std::min(node.far, more.far), std::max(node.near, more.near)};
      }
      coarse.nodes.push_back(node);
      bool joined = true;  // 2×2 nodes are 4×4 of the finer level
      for (int k = 0; k < 9 && joined; ++k) {
        joined = fine.IsJoined(2 * x + k % 3, 2 * y + k / 3);
      }
      coarse.joined.push_back(joined);
    }
  }
  return coarse;
}

}  // namespace penumbra
