#include "render/scene/triangle_clusters.h"

#include <algorithm>
#include <array>

#include "gtest/gtest.h"
#include "tests/support/random_scene.h"

namespace penumbra::testing {
namespace {

struct Soup {
  std::vector<Vec3> positions;
  std::vector<uint32_t> indices;
};

Soup RandomSoup(int triangles) {
  Dice dice(triangles + 1);
  Soup soup;
  for (int v = 0; v < triangles / 2 + 3; ++v) soup.positions.push_back(dice.InCube(5));
  for (int i = 0; i < 3 * triangles; ++i) {
    soup.indices.push_back(dice.Below(static_cast<uint32_t>(soup.positions.size())));
  }
  return soup;
}

using Triangle = std::array<uint32_t, 3>;

std::vector<Triangle> Sorted(std::vector<Triangle> triangles) {
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

TEST(TriangleClustersTest, EveryTriangleIsInOneClusterWithItsCornersInOrder) {
  for (const int count : {0, 1, 128, 129, 5000}) {
    const Soup soup = RandomSoup(count);
    const TriangleClusters clusters = ClusterTriangles(soup.positions, soup.indices);
    std::vector<Triangle> expected, found;
    for (size_t t = 0; t < soup.indices.size(); t += 3) {
      expected.push_back({soup.indices[t], soup.indices[t + 1], soup.indices[t + 2]});
    }
    ASSERT_EQ(clusters.first_triangle.size(), clusters.size() + 1);
    for (uint32_t c = 0; c < clusters.size(); ++c) {
      const uint32_t first = clusters.first_vertex[c];
      EXPECT_LE(clusters.first_triangle[c + 1] - clusters.first_triangle[c], kClusterTriangles);
      for (uint32_t t = clusters.first_triangle[c]; t < clusters.first_triangle[c + 1]; ++t) {
        Triangle& triangle = found.emplace_back();
        for (int k = 0; k < 3; ++k) {
          const uint16_t corner = clusters.corners[3 * t + k];
          ASSERT_LT(first + corner, clusters.first_vertex[c + 1]);
          triangle[k] = clusters.vertices[first + corner];
          const Vec3 at = soup.positions[triangle[k]];
          const Aabb& box = clusters.bounds[c];
          EXPECT_TRUE(glm::min(box.min, at) == box.min && glm::max(box.max, at) == box.max);
        }
      }
    }
    EXPECT_EQ(Sorted(found), Sorted(expected)) << count;
  }
}

TEST(TriangleClustersTest, NeighboursAreTogetherAndMemoryIsBounded) {
  // A grid: 100 × 100 squares.
  Soup grid;
  constexpr uint32_t kSide = 100;
  for (uint32_t i = 0; i <= kSide; ++i) {
    for (uint32_t j = 0; j <= kSide; ++j) grid.positions.emplace_back(i, 0, j);
  }
  for (uint32_t i = 0; i < kSide; ++i) {
    for (uint32_t j = 0; j < kSide; ++j) {
      const uint32_t a = i * (kSide + 1) + j, b = a + kSide + 1;
      grid.indices.insert(grid.indices.end(), {a, b, a + 1, a + 1, b, b + 1});
    }
  }
  const TriangleClusters clusters = ClusterTriangles(grid.positions, grid.indices);
  for (const Aabb& box : clusters.bounds) EXPECT_LE(box.extent().x * box.extent().z, 150);
  EXPECT_LE(clusters.bytes(), size_t{15} * grid.indices.size() / 3);
}

}  // namespace
}  // namespace penumbra::testing
