#include "client/display/polygon_mesh.h"

#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace penumbra {
namespace {

// Positive where a, b, c turn left, seen against `normal`.
double Turn(DVec3 a, DVec3 b, DVec3 c, DVec3 normal) {
  return glm::dot(glm::cross(b - a, c - b), normal);
}

// Clips one corner after another off a ring of vertices.
class EarClipper {
 public:
  EarClipper(std::span<const Vec3> vertices, DVec3 normal)
      : points_(vertices.begin(), vertices.end()), normal_(normal), ring_(vertices.size()) {
    std::iota(ring_.begin(), ring_.end(), 0u);
  }

  std::vector<uint32_t> Clip() {
    std::vector<uint32_t> indices;
    size_t at = 0, since_last = 0;
    while (ring_.size() > 3 && since_last < ring_.size()) {
      const size_t n = ring_.size();
      at %= n;
      const uint32_t a = ring_[(at + n - 1) % n], b = ring_[at], c = ring_[(at + 1) % n];
      if (IsEar(a, b, c)) {
        indices.insert(indices.end(), {a, b, c});
        ring_.erase(ring_.begin() + static_cast<std::ptrdiff_t>(at));
        since_last = 0;
      } else {
        ++at;
        ++since_last;
      }
    }
    if (ring_.size() == 3) indices.insert(indices.end(), ring_.begin(), ring_.end());
    return indices;
  }

 private:
  // No other vertex may lie in the triangle that is cut off.
  bool IsEar(uint32_t a, uint32_t b, uint32_t c) const {
    const DVec3 pa = points_[a], pb = points_[b], pc = points_[c];
    if (Turn(pa, pb, pc, normal_) < 0) return false;
    for (const uint32_t other : ring_) {
      if (other == a || other == b || other == c) continue;
      const DVec3 p = points_[other];
      if (Turn(pa, pb, p, normal_) >= 0 && Turn(pb, pc, p, normal_) >= 0 &&
          Turn(pc, pa, p, normal_) >= 0) {
        return false;
      }
    }
    return true;
  }

  std::vector<DVec3> points_;
  DVec3 normal_;
  std::vector<uint32_t> ring_;
};

}  // namespace

std::shared_ptr<const Mesh> MeshOfPolygon(std::span<const Vec3> vertices) {
  if (vertices.size() < 3) return nullptr;
  DVec3 normal(0.0);
  const DVec3 first(vertices[0]);
  for (size_t i = 1; i + 1 < vertices.size(); ++i) {
    normal += glm::cross(DVec3(vertices[i]) - first, DVec3(vertices[i + 1]) - first);
  }
  if (!(glm::length(normal) > 0)) return nullptr;
  MeshGeometry geometry;
  geometry.positions.assign(vertices.begin(), vertices.end());
  geometry.indices = EarClipper(vertices, normal).Clip();
  auto mesh = Mesh::Create(std::move(geometry));
  return mesh.ok() ? *std::move(mesh) : nullptr;
}

}  // namespace penumbra
