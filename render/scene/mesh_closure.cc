#include "render/scene/mesh_closure.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <vector>

#include "render/scene/mesh_weld.h"

namespace penumbra {
namespace {

// Directed edges, each once and each with its reverse: the surface has no boundary.
bool EveryEdgeHasItsReverse(std::vector<uint64_t>& edges) {
  std::sort(edges.begin(), edges.end());
  if (std::adjacent_find(edges.begin(), edges.end()) != edges.end()) return false;
  return std::all_of(edges.begin(), edges.end(), [&](uint64_t edge) {
    return std::binary_search(edges.begin(), edges.end(), std::rotl(edge, 32));
  });
}

uint32_t FindRoot(std::vector<uint32_t>& parent, uint32_t v) {
  while (parent[v] != v) {
    parent[v] = parent[parent[v]];
    v = parent[v];
  }
  return v;
}

}  // namespace

MeshClosure FindClosure(std::span<const Vec3> positions, std::span<const uint32_t> indices) {
  const std::vector<uint32_t> welded = WeldByPosition(positions);
  std::vector<uint32_t> corners;
  std::vector<uint64_t> edges;
  corners.reserve(indices.size());
  edges.reserve(indices.size());
  for (size_t t = 0; t + 2 < indices.size(); t += 3) {
    const uint32_t v[3] = {welded[indices[t]], welded[indices[t + 1]], welded[indices[t + 2]]};
    if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) continue;
    for (int k = 0; k < 3; ++k) {
      corners.push_back(v[k]);
      edges.push_back(uint64_t{v[k]} << 32 | v[(k + 1) % 3]);
    }
  }
  if (corners.empty() || !EveryEdgeHasItsReverse(edges)) return MeshClosure::kOpen;

  std::vector<uint32_t> parent(positions.size());
  std::iota(parent.begin(), parent.end(), 0u);
  for (size_t c = 0; c < corners.size(); c += 3) {
    const uint32_t root = FindRoot(parent, corners[c]);
    parent[FindRoot(parent, corners[c + 1])] = root;
    parent[FindRoot(parent, corners[c + 2])] = root;
  }
  // Six times the signed volume of each part; its sign is the orientation of the part's faces.
  // Taken about a vertex of the part, so that a small part far from the origin keeps its sign.
  std::vector<double> volume(positions.size(), 0.0);
  for (size_t c = 0; c < corners.size(); c += 3) {
    const uint32_t root = FindRoot(parent, corners[c]);
    const DVec3 about(positions[root]);
    volume[root] += glm::dot(DVec3(positions[corners[c]]) - about,
                             glm::cross(DVec3(positions[corners[c + 1]]) - about,
                                        DVec3(positions[corners[c + 2]]) - about));
  }
  for (size_t c = 0; c < corners.size(); c += 3) {
    if (!(volume[FindRoot(parent, corners[c])] > 0)) return MeshClosure::kClosed;
  }
  return MeshClosure::kClosedOutward;
}

}  // namespace penumbra
