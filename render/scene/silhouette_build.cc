// SilhouetteEdges from a mesh: pairing faces, and putting edges in order.

#include <algorithm>
#include <array>
#include <cmath>

#include "render/math/aabb.h"
#include "render/scene/mesh_weld.h"
#include "render/scene/silhouette_bounds.h"
#include "render/scene/silhouette_edges.h"
#include "render/scene/silhouette_kernel.h"

namespace penumbra {
namespace {

// How much a metre of distance counts against a radian between normals when edges are put together,
// for a mesh of one metre: as much as it turns the direction to a light two metres away.
constexpr double kPlaceWeight = 0.5;

// A face's edge from the vertex `from` to `to`, both welded.
struct HalfEdge {
  uint32_t from, to;
  uint32_t face;

  bool runs_up() const { return from < to; }
  uint64_t key() const { return runs_up() ? uint64_t{from} << 32 | to : uint64_t{to} << 32 | from; }
};

struct SharedEdge {
  uint32_t from, to;
  uint32_t left_face, right_face;
};

// Where an edge lies, and how its faces do: near in this space is culled together.
struct EdgePlace {
  static constexpr int kDimensions = 9;

  std::array<float, kDimensions> at;  // both normals, and the weighted position
  uint32_t edge;
};

// Faces with three different vertices, by theirs.
std::vector<std::array<uint32_t, 3>> WeldedFaces(std::span<const Vec3> positions,
                                                 std::span<const uint32_t> indices) {
  const std::vector<uint32_t> welded = WeldByPosition(positions);
  std::vector<std::array<uint32_t, 3>> faces;
  faces.reserve(indices.size() / 3);
  for (size_t t = 0; t + 2 < indices.size(); t += 3) {
    const std::array v = {welded[indices[t]], welded[indices[t + 1]], welded[indices[t + 2]]};
    if (v[0] != v[1] && v[1] != v[2] && v[2] != v[0]) faces.push_back(v);
  }
  return faces;
}

// (normal, offset) with a unit normal; all zeros for a face of no area.
DVec4 PlaneOf(DVec3 a, DVec3 b, DVec3 c) {
  const DVec3 normal = glm::cross(b - a, c - a);
  const double length = glm::length(normal);
  if (!(length > 0)) return DVec4(0.0);
  return {normal / length, glm::dot(normal / length, a)};
}

void SetPlane(FacePlanes& planes, size_t place, const DVec4& plane) {
  planes.x[place] = static_cast<float>(plane.x);
  planes.y[place] = static_cast<float>(plane.y);
  planes.z[place] = static_cast<float>(plane.z);
  planes.offset[place] = static_cast<float>(plane.w);
}

}  // namespace

// Pairs up the faces' edges, orders the pairs, and bounds runs of them.
struct SilhouetteEdges::Builder {
  SilhouetteEdges& result;
  std::span<const Vec3> positions;
  std::vector<std::array<uint32_t, 3>> faces;
  std::vector<DVec4> planes;  // one a face
  std::vector<SharedEdge> shared;
  std::vector<EdgePlace> places{};  // of the shared edges, in the order of clusters in the end
  Aabb bounds{};

  DVec3 PositionOf(uint32_t vertex) const { return DVec3(positions[vertex]) - result.center_; }

  void MakePlanes() {
    for (const auto& face : faces) {
      for (const uint32_t v : face) bounds.Add(positions[v]);
    }
    if (!bounds.empty()) {
      result.center_ = 0.5 * (DVec3(bounds.min) + DVec3(bounds.max));
      result.extent_ = 0.5 * glm::length(DVec3(bounds.max) - DVec3(bounds.min));
    }
    planes.reserve(faces.size());
    for (const auto& [a, b, c] : faces) {
      planes.push_back(PlaneOf(PositionOf(a), PositionOf(b), PositionOf(c)));
    }
  }

  std::vector<HalfEdge> HalfEdges() const {
    std::vector<HalfEdge> edges;
    edges.reserve(3 * faces.size());
    for (uint32_t f = 0; f < faces.size(); ++f) {
      for (int k = 0; k < 3; ++k) edges.push_back({faces[f][k], faces[f][(k + 1) % 3], f});
    }
    std::sort(edges.begin(), edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
      if (a.key() != b.key()) return a.key() < b.key();
      return a.runs_up() != b.runs_up() ? a.runs_up() : a.face < b.face;
    });
    return edges;
  }

  // Any pairing of faces that run along an edge in opposite directions gives the same sums; what
  // finds no partner is an edge of one face.
  void Pair() {
    const std::vector<HalfEdge> edges = HalfEdges();
    for (size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
      while (end < edges.size() && edges[end].key() == edges[begin].key()) ++end;
      const auto first = edges.begin() + static_cast<std::ptrdiff_t>(begin);
      const auto last = edges.begin() + static_cast<std::ptrdiff_t>(end);
      auto up = first;
      auto down = std::find_if(first, last, [](const HalfEdge& e) { return !e.runs_up(); });
      const auto up_end = down;
      while (up != up_end && down != last) {
        shared.push_back({up->from, up->to, up->face, down->face});
        ++up;
        ++down;
      }
      for (; up != up_end; ++up) AddBorder(*up);
      for (; down != last; ++down) AddBorder(*down);
    }
  }

  void AddBorder(const HalfEdge& edge) {
    const size_t place = result.border_count_++ % kClusterEdges;
    if (place == 0) result.border_.emplace_back();
    BorderCluster& cluster = result.border_.back();
    cluster.from[place] = edge.from;
    cluster.to[place] = edge.to;
    SetPlane(cluster.left, place, planes[edge.face]);
  }

  void MakePlaces() {
    const DVec3 extent(bounds.extent());
    const double weight = kPlaceWeight / std::max({extent.x, extent.y, extent.z, 1e-30});
    places.reserve(shared.size());
    for (uint32_t e = 0; e < shared.size(); ++e) {
      const DVec3 left(planes[shared[e].left_face]), right(planes[shared[e].right_face]);
      const DVec3 middle = 0.5 * weight * (PositionOf(shared[e].from) + PositionOf(shared[e].to));
      EdgePlace& place = places.emplace_back();
      place.edge = e;
      for (int c = 0; c < 3; ++c) {
        place.at[c] = static_cast<float>(left[c]);
        place.at[3 + c] = static_cast<float>(right[c]);
        place.at[6 + c] = static_cast<float>(middle[c]);
      }
    }
  }

  int WidestDimension(uint32_t first, uint32_t count) const {
    std::array<float, EdgePlace::kDimensions> low = places[first].at, high = low;
    for (uint32_t e = first; e < first + count; ++e) {
      for (int d = 0; d < EdgePlace::kDimensions; ++d) {
        low[d] = std::min(low[d], places[e].at[d]);
        high[d] = std::max(high[d], places[e].at[d]);
      }
    }
    int widest = 0;
    for (int d = 1; d < EdgePlace::kDimensions; ++d) {
      if (high[d] - low[d] > high[widest] - low[widest]) widest = d;
    }
    return widest;
  }

  // Halves the run where it is widest until it is a cluster.
  void Order(uint32_t first, uint32_t count) {
    if (count <= kClusterEdges) return;
    const int d = WidestDimension(first, count);
    const auto half =
        static_cast<uint32_t>((count / 2 + kClusterEdges - 1) / kClusterEdges * kClusterEdges);
    const auto begin = places.begin() + first;
    std::nth_element(begin, begin + half, begin + count,
                     [d](const EdgePlace& a, const EdgePlace& b) {
                       return a.at[d] != b.at[d] ? a.at[d] < b.at[d] : a.edge < b.edge;
                     });
    Order(first, half);
    Order(first + half, count - half);
  }

  FaceBound BoundOf(size_t first, size_t count) const {
    Aabb box;
    DVec3 sum(0.0);
    const auto for_each_face = [&](const auto& visit) {
      for (size_t e = first; e < first + count; ++e) {
        visit(shared[places[e].edge].left_face);
        visit(shared[places[e].edge].right_face);
      }
    };
    for_each_face([&](uint32_t face) {
      for (const uint32_t v : faces[face]) box.Add(Vec3(PositionOf(v)));
      sum += DVec3(planes[face]);
    });
    FaceBound bound{.center = DVec3(box.center()),
                    .radius = 0.5 * glm::length(DVec3(box.extent()))};
    if (glm::length(sum) > 0) bound.axis = glm::normalize(sum);
    double cos_spread = 1;
    for_each_face([&](uint32_t face) {
      const DVec3 normal(planes[face]);
      // The plane of a face of no area has no side; with it in, nothing can be said of all.
      cos_spread = std::min(cos_spread, normal != DVec3(0.0) ? glm::dot(bound.axis, normal) : -1.0);
    });
    bound.spread = std::acos(std::clamp(cos_spread, -1.0, 1.0));
    return bound;
  }

  void MakeLevels() {
    std::vector<FaceBound> bounds_of_level;
    for (size_t first = 0; first < places.size(); first += kClusterEdges) {
      bounds_of_level.push_back(BoundOf(first, std::min(kClusterEdges, places.size() - first)));
    }
    while (!bounds_of_level.empty()) {
      const size_t count = bounds_of_level.size();
      bounds_of_level.resize((count + kClusterEdges - 1) / kClusterEdges * kClusterEdges);
      ClusterLevel& level = result.levels_.emplace_back();
      level.count = count;
      for (const FaceBound& bound : bounds_of_level) Push(bound, level);
      if (count <= kClusterEdges) break;
      std::vector<FaceBound> parents(bounds_of_level.size() / kClusterEdges);
      for (size_t c = 0; c < count; ++c) {
        parents[c / kClusterEdges] = Around(parents[c / kClusterEdges], bounds_of_level[c]);
      }
      bounds_of_level = std::move(parents);
    }
  }

  void StoreInOrder() {
    result.shared_count_ = places.size();
    result.shared_.resize((places.size() + kClusterEdges - 1) / kClusterEdges);
    for (size_t e = 0; e < places.size(); ++e) {
      const SharedEdge& edge = shared[places[e].edge];
      EdgeCluster& cluster = result.shared_[e / kClusterEdges];
      const size_t place = e % kClusterEdges;
      cluster.from[place] = edge.from;
      cluster.to[place] = edge.to;
      SetPlane(cluster.left, place, planes[edge.left_face]);
      SetPlane(cluster.right, place, planes[edge.right_face]);
    }
  }
};

SilhouetteEdges::SilhouetteEdges(std::span<const Vec3> positions,
                                 std::span<const uint32_t> indices) {
  Builder builder{.result = *this,
                  .positions = positions,
                  .faces = WeldedFaces(positions, indices),
                  .planes = {},
                  .shared = {}};
  builder.MakePlanes();
  builder.Pair();
  builder.MakePlaces();
  builder.Order(0, static_cast<uint32_t>(builder.shared.size()));
  builder.MakeLevels();
  builder.StoreInOrder();
}

}  // namespace penumbra
