#include "client/display/polygon_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace penumbra {
namespace {

// The sum of the triangles' areas as seen from +z, negative for those that face away.
double SignedArea(const Mesh& mesh, bool& all_face_front) {
  double sum = 0;
  for (size_t t = 0; t < mesh.indices().size(); t += 3) {
    const DVec3 a(mesh.positions()[mesh.indices()[t]]), b(mesh.positions()[mesh.indices()[t + 1]]),
        c(mesh.positions()[mesh.indices()[t + 2]]);
    const double area = 0.5 * glm::cross(b - a, c - a).z;
    all_face_front = all_face_front && area >= 0;
    sum += area;
  }
  return sum;
}

TEST(PolygonMesh, AnLIsFourTriangles) {
  const std::vector<Vec3> l = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}};
  const auto mesh = MeshOfPolygon(l);
  ASSERT_NE(mesh, nullptr);
  EXPECT_EQ(mesh->triangle_count(), 4u);
  bool all_face_front = true;
  EXPECT_NEAR(SignedArea(*mesh, all_face_front), 3, 1e-9);
  EXPECT_TRUE(all_face_front);
}

TEST(PolygonMesh, RandomStarsKeepTheirArea) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int round = 0; round < 100; ++round) {
    const int corners = 3 + static_cast<int>(30 * uniform(random));
    std::vector<Vec3> star;
    for (int k = 0; k < corners; ++k) {
      const double angle = 2 * std::numbers::pi * (k + 0.8 * uniform(random)) / corners;
      const double radius = 0.2 + 2 * uniform(random);
      star.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0);
    }
    double area = 0;  // by the trapezoids under its edges
    for (int k = 0; k < corners; ++k) {
      const DVec3 a(star[k]), b(star[(k + 1) % corners]);
      area += 0.5 * (a.x - b.x) * (a.y + b.y);
    }
    const auto mesh = MeshOfPolygon(star);
    ASSERT_NE(mesh, nullptr);
    EXPECT_EQ(mesh->triangle_count(), star.size() - 2);
    bool all_face_front = true;
    EXPECT_NEAR(SignedArea(*mesh, all_face_front), area, 1e-6);
    EXPECT_TRUE(all_face_front);
  }
}

TEST(PolygonMesh, NothingIsNoMesh) {
  EXPECT_EQ(MeshOfPolygon({}), nullptr);
  EXPECT_EQ(MeshOfPolygon(std::vector<Vec3>(3, Vec3(1))), nullptr);
}

}  // namespace
}  // namespace penumbra
