// The outlines of meshes, against every edge looked at one by one in double precision.
#include "render/scene/silhouette_edges.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "gtest/gtest.h"
#include "render/scene/mesh.h"
#include "tests/support/random_scene.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

// A ball with dents; `dents` 0: smooth.
MeshGeometry Ball(int around, int across, double dents) {
  MeshGeometry ball = BallGeometry(around, across);
  Dice dice(5);
  for (Vec3& p : ball.positions) {
    const bool is_pole = p.x == 0 && p.z == 0;
    if (!is_pole) p *= static_cast<float>(1 + dents * dice.Between(-1, 1));
  }
  return ball;
}

// Triangles between few vertices: edges of many faces, faces back to back, of no area, repeated.
MeshGeometry Tangle(uint64_t seed) {
  Dice dice(seed);
  MeshGeometry tangle;
  for (int i = 0; i < 12; ++i) tangle.positions.push_back(dice.InCube(1));
  tangle.positions.push_back(tangle.positions[0]);
  for (int t = 0; t < 60; ++t) {
    for (int k = 0; k < 3; ++k) tangle.indices.push_back(dice.Below(13));
  }
  return tangle;
}

using Place = std::tuple<float, float, float>;

Place PlaceOf(Vec3 p) { return {p.x, p.y, p.z}; }

// The sum of what each edge is crossed with, per pair of places; edges that cancel are left out.
using Crossings = std::map<std::pair<Place, Place>, int>;

void Cross(Vec3 from, Vec3 to, int weight, Crossings& crossings) {
  const Place a = PlaceOf(from), b = PlaceOf(to);
  if (a == b) return;  // an edge of no length
  const auto key = a < b ? std::pair(a, b) : std::pair(b, a);
  const int sum = crossings[key] += a < b ? weight : -weight;
  if (sum == 0) crossings.erase(key);
}

Crossings OfList(const MeshGeometry& mesh, const SilhouetteList& list) {
  Crossings crossings;
  for (size_t e = 0; e < list.count; ++e) {
    Cross(mesh.positions[list.from[e]], mesh.positions[list.to[e]], list.weight[e], crossings);
  }
  return crossings;
}

// Every face's three edges with its facing: what the outline has to add up to.
Crossings OfFaces(const MeshGeometry& mesh, DVec4 viewpoint) {
  Crossings crossings;
  for (size_t t = 0; t < mesh.indices.size(); t += 3) {
    const auto p = [&](size_t k) { return mesh.positions[mesh.indices[t + k % 3]]; };
    const DVec3 normal = glm::cross(DVec3(p(1)) - DVec3(p(0)), DVec3(p(2)) - DVec3(p(0)));
    const DVec3 towards = DVec3(viewpoint) - viewpoint.w * DVec3(p(0));
    const int facing = glm::dot(normal, towards) > 0 ? 1 : -1;
    for (size_t k = 0; k < 3; ++k) Cross(p(k), p(k + 1), facing, crossings);
  }
  return crossings;
}

DVec4 SomeViewpoint(Dice& dice) {
  const Vec3 direction = dice.Direction();
  if (dice.Below(3) == 0) return DVec4(DVec3(direction), 0);
  return DVec4(DVec3(dice.Between(0.2f, 8) * direction), 1);
}

void ExpectOutlines(const MeshGeometry& mesh, int viewpoints) {
  const SilhouetteEdges edges(mesh.positions, mesh.indices);
  Dice dice(17);
  for (int v = 0; v < viewpoints; ++v) {
    const DVec4 viewpoint = SomeViewpoint(dice);
    SilhouetteList found, seen;
    std::vector<SilhouetteList> by_clusters(1);
    edges.Find(viewpoint, found);
    edges.FindEach(std::span(&viewpoint, 1), by_clusters);
    const Crossings expected = OfFaces(mesh, viewpoint);
    ASSERT_EQ(OfList(mesh, found), expected) << v;
    ASSERT_EQ(OfList(mesh, by_clusters[0]), expected) << v;
    ASSERT_EQ(by_clusters[0].count, found.count) << v;
    const double radius = dice.Between(0, 0.5f);
    const DVec4 moved = viewpoint + DVec4(radius * DVec3(dice.Direction()), 0);
    edges.SeenFrom({moved, radius * 1.0001}).Find(viewpoint, seen);
    ASSERT_EQ(OfList(mesh, seen), expected) << v;
  }
}

// Of `count` viewpoints near each other, all edges and those that are left of them.
void ExpectOutlinesOfNeighbours(const MeshGeometry& mesh, size_t count) {
  const SilhouetteEdges edges(mesh.positions, mesh.indices);
  Dice dice(29);
  const DVec4 first = SomeViewpoint(dice);
  std::vector<DVec4> viewpoints = {first};
  while (viewpoints.size() < count) {
    viewpoints.push_back(first + DVec4(double{dice.Between(0, 0.3f)} * DVec3(dice.Direction()), 0));
  }
  const SilhouetteEdges seen = edges.SeenFrom(ViewBall::Around(viewpoints));
  std::vector<SilhouetteList> of_all(count), of_seen(count);
  edges.FindEach(viewpoints, of_all);
  seen.FindEach(viewpoints, of_seen);
  for (size_t v = 0; v < count; ++v) {
    const Crossings expected = OfFaces(mesh, viewpoints[v]);
    ASSERT_EQ(OfList(mesh, of_all[v]), expected) << v;
    ASSERT_EQ(OfList(mesh, of_seen[v]), expected) << v;
  }
  // What is there is kept.
  const size_t before = of_seen.front().count;
  seen.FindEach(std::span(viewpoints).first(1), of_seen);
  EXPECT_EQ(of_seen.front().count, 2 * before);
}

TEST(SilhouetteEdges, OfNeighboursTogether) {
  for (const size_t count : {1, 2, 7, 8, 9, 16, 21}) {
    ExpectOutlinesOfNeighbours(Ball(40, 30, 0), count);
    ExpectOutlinesOfNeighbours(Ball(50, 50, 0.1), count);
    ExpectOutlinesOfNeighbours(UnitBoxGeometry(), count);
    ExpectOutlinesOfNeighbours(UnitSquareGeometry(), count);
    ExpectOutlinesOfNeighbours(Tangle(count), count);
    ExpectOutlinesOfNeighbours({}, count);
  }
}

TEST(SilhouetteEdges, OfSmoothAndDentedBalls) {
  ExpectOutlines(Ball(40, 30, 0), 60);
  ExpectOutlines(Ball(50, 50, 0.1), 60);
}

// Several levels of clusters.
TEST(SilhouetteEdges, OfALargeBall) { ExpectOutlines(Ball(200, 120, 0.02), 4); }

TEST(SilhouetteEdges, OfBoxesSquaresAndNothing) {
  ExpectOutlines(UnitBoxGeometry(), 60);
  ExpectOutlines(UnitSquareGeometry(), 60);
  ExpectOutlines({}, 2);
}

TEST(SilhouetteEdges, OfMeshesThatAreNoManifolds) {
  for (uint64_t seed = 0; seed < 60; ++seed) ExpectOutlines(Tangle(seed), 20);
}

// From where suns stand that have been set by hand: there, some bounds are seen edge-on to the bit.
TEST(SilhouetteEdges, FromAlongTheAxes) {
  for (const MeshGeometry& mesh :
       {Ball(40, 30, 0), Ball(50, 50, 0.1), UnitBoxGeometry(), Tangle(3)}) {
    const SilhouetteEdges edges(mesh.positions, mesh.indices);
    for (int axis = 0; axis < 6; ++axis) {
      DVec4 viewpoint(0.0);
      viewpoint[axis / 2] = axis % 2 ? -1 : 1;
      for (const double w : {0.0, 1e-3}) {
        viewpoint.w = w;
        SilhouetteList found, seen;
        std::vector<SilhouetteList> by_clusters(1);
        edges.Find(viewpoint, found);
        edges.FindEach(std::span(&viewpoint, 1), by_clusters);
        edges.SeenFrom({viewpoint, 1e-3}).Find(viewpoint, seen);
        ASSERT_EQ(OfList(mesh, by_clusters[0]), OfList(mesh, found)) << axis;
        ASSERT_EQ(by_clusters[0].count, found.count) << axis;
        ASSERT_EQ(OfList(mesh, seen), OfList(mesh, found)) << axis;
      }
    }
  }
}

TEST(SilhouetteEdges, AClosedMeshHasSharedEdgesOnly) {
  const MeshGeometry ball = Ball(40, 30, 0);
  const SilhouetteEdges edges(ball.positions, ball.indices);
  EXPECT_EQ(edges.border_edge_count(), 0u);
  EXPECT_GT(edges.shared_edge_count(), 3000u);
  const MeshGeometry square = UnitSquareGeometry();
  const SilhouetteEdges open(square.positions, square.indices);
  EXPECT_EQ(open.border_edge_count(), 4u);
  EXPECT_EQ(open.shared_edge_count(), 1u);
}

TEST(SilhouetteEdges, AMeshKeepsItsOwn) {
  const auto mesh = MeshOf(Ball(8, 6, 0));
  EXPECT_EQ(&mesh->silhouette_edges(), &mesh->silhouette_edges());
}

}  // namespace
}  // namespace penumbra::testing
