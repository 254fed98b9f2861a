#include "render/scene/mesh_weld.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace penumbra {

std::vector<uint32_t> WeldByPosition(std::span<const Vec3> positions) {
  std::vector<uint32_t> order(positions.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto key = [&](uint32_t v) {
    const Vec3& p = positions[v];
    return std::tuple(p.x, p.y, p.z);
  };
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return key(a) < key(b); });
  std::vector<uint32_t> welded(positions.size());
  for (size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && positions[order[i]] == positions[order[i - 1]];
    welded[order[i]] = same ? welded[order[i - 1]] : order[i];
  }
  return welded;
}

}  // namespace penumbra
