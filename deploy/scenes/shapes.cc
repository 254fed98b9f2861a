#include "deploy/scenes/shapes.h"

#include <cmath>
#include <numbers>
#include <vector>

namespace penumbra::sample {
namespace {

Vec3 OnGrid(DVec3 p) { return Vec3(glm::round(p * 65536.0) / 65536.0); }

uint32_t AddVertex(MeshGeometry& mesh, DVec3 position, DVec3 normal) {
  mesh.positions.push_back(OnGrid(position));
  mesh.normals.push_back(OnGrid(glm::normalize(normal)));
  return static_cast<uint32_t>(mesh.positions.size() - 1);
}

// Corners as bits: 1 = second along u, 2 = along v, 4 = along w; u × v points along w.
MeshGeometry Hexahedron(const std::array<Vec3, 8>& corner) {
  constexpr std::array<std::array<int, 4>, 6> kFaces = {
      {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
  MeshGeometry mesh;
  for (const auto& f : kFaces) {
    Append(mesh, Quad(corner[f[0]], corner[f[1]], corner[f[2]], corner[f[3]]));
  }
  return mesh;
}

DVec3 AroundAxis(double radius, double height, int step, int segments) {
  const double angle = 2.0 * std::numbers::pi * (step % segments) / segments;
  return {radius * std::cos(angle), height, -radius * std::sin(angle)};
}

// The outward normal (radius, height) of the profile at point i.
DVec2 ProfileNormal(std::span<const Vec2> profile, size_t i) {
  const DVec2 before(profile[i == 0 ? 0 : i - 1]);
  const DVec2 after(profile[i + 1 == profile.size() ? i : i + 1]);
  return {after.y - before.y, before.x - after.x};
}

Vec2 CatmullRom(std::span<const Vec2> points, size_t i, double t) {
  const DVec2 a(points[i == 0 ? 0 : i - 1]), b(points[i]), c(points[i + 1]);
  const DVec2 d(points[std::min(i + 2, points.size() - 1)]);
  const DVec2 p = 0.5 * (2.0 * b + t * (c - a) + t * t * (2.0 * a - 5.0 * b + 4.0 * c - d) +
                         t * t * t * (3.0 * b - a - 3.0 * c + d));
  return {std::max(0.0, p.x), p.y};
}

}  // namespace

void Append(MeshGeometry& whole, const MeshGeometry& part) {
  const auto base = static_cast<uint32_t>(whole.positions.size());
  whole.positions.insert(whole.positions.end(), part.positions.begin(), part.positions.end());
  whole.normals.insert(whole.normals.end(), part.normals.begin(), part.normals.end());
  whole.uvs.insert(whole.uvs.end(), part.uvs.begin(), part.uvs.end());
  for (const uint32_t index : part.indices) whole.indices.push_back(base + index);
}

MeshGeometry Quad(Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
  MeshGeometry mesh;
  const DVec3 normal = glm::cross(DVec3(c) - DVec3(a), DVec3(d) - DVec3(b));
  for (const Vec3 p : {a, b, c, d}) AddVertex(mesh, p, normal);
  mesh.indices = {0, 1, 2, 0, 2, 3};
  return mesh;
}

MeshGeometry Box(Vec3 min, Vec3 max) {
  std::array<Vec3, 8> corner;
  for (int i = 0; i < 8; ++i) {
    corner[i] = {i & 1 ? max.x : min.x, i & 2 ? max.y : min.y, i & 4 ? max.z : min.z};
  }
  return Hexahedron(corner);
}

MeshGeometry Bar(Vec3 from, Vec3 to, Vec2 size_from, Vec2 size_to, Vec3 side) {
  const DVec3 along = glm::normalize(DVec3(to) - DVec3(from));
  const DVec3 v = glm::normalize(glm::cross(along, DVec3(side)));
  const DVec3 u = glm::cross(v, along);
  std::array<Vec3, 8> corner;
  for (int i = 0; i < 8; ++i) {
    const DVec2 half = 0.5 * DVec2(i & 4 ? size_to : size_from);
    corner[i] = Vec3(DVec3(i & 4 ? to : from) + (i & 1 ? half.x : -half.x) * u +
                     (i & 2 ? half.y : -half.y) * v);
  }
  return Hexahedron(corner);
}

MeshGeometry Turned(std::span<const Vec2> profile, int segments) {
  MeshGeometry mesh;
  for (size_t i = 0; i < profile.size(); ++i) {
    const DVec2 normal = ProfileNormal(profile, i);
    for (int s = 0; s <= segments; ++s) {
      AddVertex(mesh, AroundAxis(profile[i].x, profile[i].y, s, segments),
                AroundAxis(normal.x, normal.y, s, segments));
    }
  }
  const auto row = static_cast<uint32_t>(segments + 1);
  for (uint32_t i = 0; i + 1 < profile.size(); ++i) {
    if (profile[i] == profile[i + 1]) continue;  // an edge: one ring for each side's normals
    for (uint32_t s = 0; s + 1 < row; ++s) {
      const uint32_t a = i * row + s, b = a + 1, c = b + row, d = a + row;
      if (profile[i].x > 0.0f) mesh.indices.insert(mesh.indices.end(), {a, b, c});
      if (profile[i + 1].x > 0.0f) mesh.indices.insert(mesh.indices.end(), {a, c, d});
    }
  }
  return mesh;
}

MeshGeometry TurnedSmooth(std::span<const Vec2> points, int steps, int segments) {
  std::vector<Vec2> profile;
  for (size_t i = 0; i + 1 < points.size(); ++i) {
    for (int k = 0; k < steps; ++k) {
      profile.push_back(CatmullRom(points, i, static_cast<double>(k) / steps));
    }
  }
  profile.push_back(points.back());
  return Turned(profile, segments);
}

MeshGeometry Ball(float radius, int rings, int segments) {
  std::vector<Vec2> profile;
  for (int i = 0; i <= rings; ++i) {
    const double angle = std::numbers::pi * i / rings;
    const bool is_pole = i == 0 || i == rings;
    profile.emplace_back(is_pole ? 0.0 : radius * std::sin(angle), -radius * std::cos(angle));
  }
  return Turned(profile, segments);
}

MeshGeometry LeafCard(const Leaf& leaf, int pieces) {
  MeshGeometry mesh;
  const DVec3 out(std::cos(leaf.azimuth), 0.0, std::sin(leaf.azimuth));
  const DVec3 across = glm::cross(DVec3(0, 1, 0), out);
  DVec3 spine(leaf.root);
  for (int i = 0; i <= pieces; ++i) {
    const double t = static_cast<double>(i) / pieces;
    const double slope = leaf.rise - leaf.droop * t;
    const DVec3 along = std::cos(slope) * out + DVec3(0.0, std::sin(slope), 0.0);
    const DVec3 normal = glm::cross(along, across);
    AddVertex(mesh, spine - 0.5 * leaf.width * across, normal);
    AddVertex(mesh, spine + 0.5 * leaf.width * across, normal);
    mesh.uvs.emplace_back(0.0f, static_cast<float>(1.0 - t));
    mesh.uvs.emplace_back(1.0f, static_cast<float>(1.0 - t));
    spine += along * (static_cast<double>(leaf.length) / pieces);
  }
  for (uint32_t i = 0; i < static_cast<uint32_t>(pieces); ++i) {
    const uint32_t a = 2 * i;
    mesh.indices.insert(mesh.indices.end(), {a, a + 2, a + 1, a + 1, a + 2, a + 3});
  }
  return mesh;
}

}  // namespace penumbra::sample
