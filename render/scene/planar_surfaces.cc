#include "render/scene/planar_surfaces.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "render/math/aabb.h"
#include "render/scene/mesh_weld.h"

namespace penumbra {
namespace {

// Share of the mesh's extent: a fifth of what a planar instance may leave its plane by, above what
// 16 bits make of a coordinate.
constexpr double kPlaneTolerance = 2e-5;
// Cosine of the angle between faces of one surface; displays ask the same of a face on a receiver.
constexpr double kSameFacing = 0.999;
// Two is a closed surface, three and four are walls that meet. A fan of thousands is no surface,
// and would be looked through from each of its blades.
constexpr size_t kMostAtAnEdge = 64;
constexpr uint32_t kNone = ~0u;

// Which triangles meet at each side of each triangle.
class EdgeNeighbours {
 public:
  EdgeNeighbours(std::span<const uint32_t> welded, std::span<const uint32_t> indices)
      : first_(indices.size()) {
    edges_.reserve(indices.size());
    for (size_t k = 0; k < indices.size(); ++k) {
      const uint32_t a = welded[indices[k]];
      const uint32_t b = welded[indices[k % 3 == 2 ? k - 2 : k + 1]];
      edges_.push_back({uint64_t{std::min(a, b)} << 32 | std::max(a, b), static_cast<uint32_t>(k)});
    }
    std::sort(edges_.begin(), edges_.end(), [](const Edge& a, const Edge& b) {
      return std::pair(a.ends, a.side) < std::pair(b.ends, b.side);
    });
    for (size_t begin = 0; begin < edges_.size();) {
      size_t end = begin;
      while (end < edges_.size() && edges_[end].ends == edges_[begin].ends) ++end;
      const bool joins = end - begin <= kMostAtAnEdge;
      for (size_t i = begin; i < end; ++i) {
        first_[edges_[i].side] = joins ? static_cast<uint32_t>(begin) : kNone;
      }
      begin = end;
    }
  }

  template <typename Visit>
  void ForEach(uint32_t triangle, const Visit& visit) const {
    for (size_t side = 3 * size_t{triangle}; side < 3 * size_t{triangle} + 3; ++side) {
      if (first_[side] == kNone) continue;
      const uint64_t ends = edges_[first_[side]].ends;
      for (size_t i = first_[side]; i < edges_.size() && edges_[i].ends == ends; ++i) {
        if (edges_[i].side / 3 != triangle) visit(edges_[i].side / 3);
      }
    }
  }

 private:
  struct Edge {
    uint64_t ends;  // both vertices, the smaller in the upper half
    uint32_t side;  // 3·triangle + which of its sides
  };

  std::vector<Edge> edges_;      // by their ends
  std::vector<uint32_t> first_;  // of each side, where the edges of its ends begin
};

class Grower {
 public:
  Grower(std::span<const Vec3> positions, std::span<const uint32_t> indices)
      : positions_(positions),
        indices_(indices),
        neighbours_(WeldByPosition(positions), indices),
        surface_of(indices.size() / 3, kNone) {
    Aabb bounds;
    for (const uint32_t index : indices) bounds.Add(positions[index]);
    tolerance_ = kPlaneTolerance * glm::length(DVec3(bounds.extent()));
  }

  // Marks the triangles of the surface around `seed`.
  void Grow(uint32_t seed, uint32_t surface) {
    seed_corner_ = Corner(seed, 0);
    seed_normal_ = glm::normalize(TwiceArea(seed));
    surface_of[seed] = surface;
    front_.assign(1, seed);
    while (!front_.empty()) {
      const uint32_t from = front_.back();
      front_.pop_back();
      neighbours_.ForEach(from, [&](uint32_t triangle) {
        if (surface_of[triangle] != kNone || !Fits(triangle)) return;
        surface_of[triangle] = surface;
        front_.push_back(triangle);
      });
    }
  }

  DVec3 TwiceArea(uint32_t t) const {
    return glm::cross(Corner(t, 1) - Corner(t, 0), Corner(t, 2) - Corner(t, 0));
  }

 private:
  DVec3 Corner(uint32_t t, int k) const { return DVec3(positions_[indices_[3 * size_t{t} + k]]); }

  bool Fits(uint32_t t) const {
    double longest = 0;
    for (int k = 0; k < 3; ++k) {
      const double off = glm::dot(Corner(t, k) - seed_corner_, seed_normal_);
      if (std::abs(off) > tolerance_) return false;
      longest = std::max(longest, glm::length(Corner(t, (k + 1) % 3) - Corner(t, k)));
    }
    const DVec3 twice_area = TwiceArea(t);
    const double size = glm::length(twice_area);
    if (size <= tolerance_ * longest) return true;  // a sliver
    return glm::dot(twice_area, seed_normal_) > kSameFacing * size;
  }

  std::span<const Vec3> positions_;
  std::span<const uint32_t> indices_;
  EdgeNeighbours neighbours_;
  double tolerance_ = 0;
  DVec3 seed_corner_{0.0}, seed_normal_{0.0};
  std::vector<uint32_t> front_;

 public:
  std::vector<uint32_t> surface_of;
};

}  // namespace

PlanarSurfaces::PlanarSurfaces(std::span<const Vec3> positions, std::span<const uint32_t> indices) {
  Grower grower(positions, indices);
  const size_t triangle_count = indices.size() / 3;
  std::vector<std::pair<double, uint32_t>> seeds;
  for (uint32_t t = 0; t < triangle_count; ++t) {
    const double size = glm::length(grower.TwiceArea(t));
    if (size > 0) seeds.emplace_back(-size, t);
  }
  std::sort(seeds.begin(), seeds.end());
  uint32_t count = 0;
  for (const auto& [size, seed] : seeds) {
    if (grower.surface_of[seed] == kNone) grower.Grow(seed, count++);
  }
  surface_of_ = std::move(grower.surface_of);
  begins_.assign(size_t{count} + 1, 0);
  for (const uint32_t surface : surface_of_) {
    if (surface != kNone) ++begins_[surface + 1];
  }
  std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
  triangles_.resize(begins_.back());
  std::vector<uint32_t> next(begins_.begin(), begins_.end() - 1);
  for (uint32_t t = 0; t < triangle_count; ++t) {
    if (surface_of_[t] != kNone) triangles_[next[surface_of_[t]]++] = t;
  }
}

std::optional<size_t> PlanarSurfaces::SurfaceOf(uint32_t triangle) const {
  if (triangle >= surface_of_.size() || surface_of_[triangle] == kNone) return std::nullopt;
  return surface_of_[triangle];
}

}  // namespace penumbra
