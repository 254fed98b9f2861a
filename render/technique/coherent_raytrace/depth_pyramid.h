// A depth map for rays to go through: the nearest, the furthest, and what is one surface, of ever
// larger squares of pixels.
//
//   const DepthPyramid pyramid(map, {}, /*covers_all=*/true);
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "render/artifact/depth_map.h"
#include "render/technique/coherent_raytrace/nearness.h"

namespace penumbra {

// Neighbouring pixels whose depths differ by no more show one surface. Of several the first that is
// given counts.
struct GapBias {
  std::optional<double> metres;
  std::optional<double> relative;  // to the nearer one's depth; from infinitely far not used
  double pixels = 3.0;             // pixels' widths at the nearer one's depth
};

class DepthPyramid {
 public:
  // Nearness: `far` of the furthest pixel, 0 if there is nothing in one of them, `near` of the
  // nearest.
  struct Node {
    float far, near;
  };
  // Nodes, and whether they are joined, of all levels.
  static constexpr double kBytesPerPixel = (sizeof(Node) + sizeof(uint8_t)) * 4.0 / 3.0;

  // covers_all  nothing that casts is beyond the map's edges
  DepthPyramid(const DepthMap& map, const GapBias& gap, bool covers_all);

  const LightView& view() const { return view_; }
  const Nearness& nearness() const { return nearness_; }
  bool covers_all() const { return covers_all_; }

  // Level 0 is the pixels; the last is one node.
  int top() const { return static_cast<int>(levels_.size()) - 1; }
  int width(int level) const { return levels_[level].width; }
  int height(int level) const { return levels_[level].height; }
  const Node& At(int level, int x, int y) const {
    const Level& l = levels_[level];
    return l.nodes[static_cast<size_t>(y) * l.width + x];
  }
  // All pixels of the node are there and each is joined to those about it in the node.
  bool IsOneSurface(int level, int x, int y) const {
    if (level == 0) return At(0, x, y).far > 0;
    return levels_[level - 1].IsJoined(2 * x, 2 * y);
  }
  // Whether two neighbours' nearness is that of one surface.
  bool AreJoined(float a, float b) const;

 private:
  struct Level {
    int width, height;
    std::vector<Node> nodes;
    std::vector<uint8_t> joined;  // the 2×2 nodes from here are one surface

    bool IsJoined(int x, int y) const {
      return x < width && y < height && joined[static_cast<size_t>(y) * width + x] != 0;
    }
  };

  void FillPixels(const DepthMap& map);
  void JoinPixels();
  Level Coarser(const Level& fine) const;

  LightView view_;
  Nearness nearness_;
  bool covers_all_;
  float gap_ = 0.0f;
  // How the gap grows with nearness: as its square where it is in metres, as itself where it is
  // relative, not at all from infinitely far.
  int gap_power_ = 0;
  std::vector<Level> levels_;
};

}  // namespace penumbra
