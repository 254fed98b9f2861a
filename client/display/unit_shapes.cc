#include "client/display/unit_shapes.h"

#include <cmath>
#include <numbers>
#include <utility>

namespace penumbra {
namespace {

std::shared_ptr<const Mesh> MakeSquare() {
  MeshGeometry geometry;
  geometry.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  geometry.indices = {0, 1, 2, 0, 2, 3};
  return *Mesh::Create(std::move(geometry));
}

std::shared_ptr<const Mesh> MakeDisk() {
  constexpr uint32_t kSides = 96;
  MeshGeometry geometry;
  for (uint32_t i = 0; i < kSides; ++i) {
    const double angle = 2 * std::numbers::pi * i / kSides;
    geometry.positions.emplace_back(std::cos(angle), std::sin(angle), 0.0);
    if (i >= 2) geometry.indices.insert(geometry.indices.end(), {0, i - 1, i});
  }
  return *Mesh::Create(std::move(geometry));
}

std::shared_ptr<const Mesh> MakeSphere() {
  constexpr uint32_t kRings = 32, kSides = 64;
  MeshGeometry geometry;
  for (uint32_t ring = 0; ring <= kRings; ++ring) {
    const double polar = std::numbers::pi * ring / kRings;
    for (uint32_t side = 0; side < kSides; ++side) {
      const double around = 2 * std::numbers::pi * side / kSides;
      geometry.positions.emplace_back(std::sin(polar) * std::cos(around), std::cos(polar),
                                      -std::sin(polar) * std::sin(around));
    }
  }
  for (uint32_t ring = 0; ring < kRings; ++ring) {
    for (uint32_t side = 0; side < kSides; ++side) {
      const uint32_t next_side = (side + 1) % kSides;
      const uint32_t a = ring * kSides + side, b = ring * kSides + next_side;
      const uint32_t c = a + kSides, d = b + kSides;
      geometry.indices.insert(geometry.indices.end(), {a, c, d, a, d, b});
    }
  }
  return *Mesh::Create(std::move(geometry));
}

}  // namespace

std::shared_ptr<const Mesh> UnitSquare() {
  static const auto* square = new std::shared_ptr<const Mesh>(MakeSquare());
  return *square;
}

std::shared_ptr<const Mesh> UnitDisk() {
  static const auto* disk = new std::shared_ptr<const Mesh>(MakeDisk());
  return *disk;
}

std::shared_ptr<const Mesh> UnitSphere() {
  static const auto* sphere = new std::shared_ptr<const Mesh>(MakeSphere());
  return *sphere;
}

}  // namespace penumbra
