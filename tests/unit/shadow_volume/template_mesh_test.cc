// The mesh against what a volume is: crossings are counted triangle by triangle, in double
// precision, and compared with where the ends of a segment are.
#include "render/technique/shadow_volume/template_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "render/artifact/shadow_volume_mesh.h"
#include "tests/unit/shadow_volume/crossings.h"
#include "tests/unit/shadow_volume/depth_maps.h"

namespace penumbra {
namespace {

using testing::CrossingsOf;
using testing::Dice;
using testing::MapOf;
using testing::RandomMap;
using testing::SomeView;

VolumeGrid GridOf(const DepthMap& map) { return VolumeGrid(map, VolumeBorder::kNothing, 0); }

VolumeTriangles TrianglesOf(const VolumeGrid& grid, const EdgeMap& edges, Reconstruction how) {
  VolumeTriangles mesh;
  AddTriangles(grid, edges, how, mesh);
  return mesh;
}

DVec3 PointIn(Dice& dice, const LightView& view) {
  const DVec2 pixel(dice.Between(-2, static_cast<float>(view.width) + 2),
                    dice.Between(-2, static_cast<float>(view.height) + 2));
  return view.PointAt(pixel, dice.Between(0.5f, 12));
}

ShadowVolumeMesh MeshWith(const DepthMap& map) {
  ShadowVolumeMesh mesh{.light = {.id = "light", .shape = PointLight{}}, .bias_px = 0};
  mesh.volumes.push_back(std::make_shared<ShadowVolume>(ShadowVolume{.faces = {{.map = map}}}));
  return mesh;
}

// Two places are both in the volume or both outside if what is between meets its boundary an even
// number of times; and which it is, signs tell.
TEST(TemplateMeshTest, ParityOfAllCellsIsThatOfTheSurface) {
  Dice dice(11);
  int compared = 0;
  for (int trial = 0; trial < 40; ++trial) {
    const bool from_infinity = trial % 2;
    const DepthMap map = RandomMap(dice, SomeView(6, 7, from_infinity));
    const VolumeGrid grid = GridOf(map);
    const VolumeTriangles all = TrianglesOf(grid, EdgeMap(grid), Reconstruction::kAllCells);
    const ShadowVolumeMesh mesh = MeshWith(map);
    const VolumeLookup lookup(mesh);
    for (int i = 0; i < 100; ++i) {
      const DVec3 from = PointIn(dice, map.view), to = PointIn(dice, map.view);
      const auto crossings = CrossingsOf(all, from, to);
      if (!crossings) continue;
      ++compared;
      EXPECT_EQ(crossings->in, lookup.Depth(to) - lookup.Depth(from)) << trial << " " << i;
      EXPECT_EQ(crossings->all % 2, std::abs(crossings->in) % 2);
    }
  }
  EXPECT_GT(compared, 3500);
}

using Sample = std::pair<uint32_t, uint32_t>;

// The sample whose corner a vertex is.
std::vector<Sample> SamplesOf(const VolumeGrid& grid, const VolumeTriangles& mesh) {
  std::map<std::array<float, 4>, Sample> samples;
  for (uint32_t y = 0; y < grid.height(); ++y) {
    for (uint32_t x = 0; x < grid.width(); ++x) {
      const Vec4 v(grid.WorldAt(x, y));
      samples[{v.x, v.y, v.z, v.w}] = {x, y};
    }
  }
  std::vector<Sample> of;
  for (const Vec4& v : mesh.vertices) of.push_back(samples.at({v.x, v.y, v.z, v.w}));
  return of;
}

// How often each pair of samples is an edge of a triangle.
std::map<std::pair<Sample, Sample>, int> EdgeUses(const VolumeGrid& grid,
                                                  const VolumeTriangles& mesh) {
  const std::vector<Sample> samples = SamplesOf(grid, mesh);
  std::map<std::pair<Sample, Sample>, int> uses;
  for (size_t i = 0; i < mesh.indices.size(); ++i) {
    const size_t next = i % 3 == 2 ? i - 2 : i + 1;
    const Sample a = samples[mesh.indices[i]], b = samples[mesh.indices[next]];
    ++uses[std::minmax(a, b)];
  }
  return uses;
}

// Each edge of the whole surface is of two triangles, but where nothing is seen at either end.
TEST(TemplateMeshTest, TheWholeSurfaceIsClosed) {
  Dice dice(12);
  for (int trial = 0; trial < 10; ++trial) {
    const VolumeGrid grid = GridOf(RandomMap(dice, SomeView(9, 8, false)));
    const VolumeTriangles all = TrianglesOf(grid, EdgeMap(grid), Reconstruction::kAllCells);
    for (const auto& [edge, uses] : EdgeUses(grid, all)) {
      const bool is_far = grid.At(edge.first.first, edge.first.second) == 0 &&
                          grid.At(edge.second.first, edge.second.second) == 0;
      if (!is_far) {
        EXPECT_EQ(uses, 2);
      }
    }
  }
}

// What the templates leave out borders on what is there along sides that are no edges.
TEST(TemplateMeshTest, TemplatesEndWhereThereIsNoEdge) {
  Dice dice(13);
  for (int trial = 0; trial < 20; ++trial) {
    const VolumeGrid grid = GridOf(RandomMap(dice, SomeView(20, 21, false), 0.1f));
    const EdgeMap edges = FindEdges(grid, {.thresholds = EdgeThresholds{.low = 15, .high = 15}});
    for (const auto how : {Reconstruction::kTemplate, Reconstruction::kFixedMesh}) {
      size_t odd = 0;
      for (const auto& [edge, uses] : EdgeUses(grid, TrianglesOf(grid, edges, how))) {
        const auto [x, y] = edge.first;
        EXPECT_LE(uses, 2);
        odd += uses == 1;
        if (uses == 2) continue;
        if (edge.second == Sample(x + 1, y)) {
          EXPECT_FALSE(edges.right(x, y));
        }
        if (edge.second == Sample(x, y + 1)) {
          EXPECT_FALSE(edges.below(x, y));
        }
      }
      EXPECT_GT(odd, 0u);
    }
  }
}

// Every triangle of a cell that has an edge among its sides is there: by its corners, not its code.
TEST(TemplateMeshTest, TemplatesHaveAllTrianglesWithAnEdge) {
  for (int split = 0; split < 2; ++split) {
    for (int code = 0; code < 16; ++code) {
      // Side k is between corners k and k + 1.
      const int corners[2][2][3] = {{{0, 1, 2}, {2, 3, 0}}, {{0, 1, 3}, {2, 3, 1}}};
      int expected = 0;
      for (int triangle = 0; triangle < 2; ++triangle) {
        for (int side = 0; side < 4; ++side) {
          const auto has = [&](int corner) {
            return std::ranges::count(corners[split][triangle], corner) > 0;
          };
          if ((code >> side & 1) && has(side) && has((side + 1) % 4)) expected |= 1 << triangle;
        }
      }
      const bool ends = code == 1 || code == 2 || code == 4 || code == 8;
      EXPECT_EQ(TemplateTriangles(code, split), ends ? 3 : expected) << code << " " << split;
    }
  }
}

// Thresholds that take every cell give the whole surface.
TEST(TemplateMeshTest, WithoutThresholdsNothingIsLeftOut) {
  Dice dice(14);
  const VolumeGrid grid = GridOf(RandomMap(dice, SomeView(17, 9, false)));
  const EdgeMap edges = FindEdges(grid, {.thresholds = EdgeThresholds{.low = 0, .high = 0}});
  const auto all = TrianglesOf(grid, EdgeMap(grid), Reconstruction::kAllCells);
  const auto fixed = TrianglesOf(grid, edges, Reconstruction::kFixedMesh);
  EXPECT_EQ(fixed.indices.size(), all.indices.size());
  EXPECT_EQ(fixed.vertices, all.vertices);
}

// The front of each triangle is towards the light.
TEST(TemplateMeshTest, FrontsAreLit) {
  Dice dice(15);
  for (const bool is_mirrored : {false, true}) {
    LightView view = SomeView(8, 8, false);
    if (is_mirrored) view.frame.axes.s = -view.frame.axes.s;
    const VolumeGrid grid = GridOf(RandomMap(dice, view, 0));
    const auto all = TrianglesOf(grid, EdgeMap(grid), Reconstruction::kAllCells);
    for (size_t i = 0; i < all.indices.size(); i += 3) {
      DVec3 at[3];
      bool is_near = true;
      for (size_t k = 0; k < 3; ++k) {
        const DVec4 v(all.vertices[all.indices[i + k]]);
        is_near = is_near && v.w > 0;
        at[k] = DVec3(v) / v.w;
      }
      if (!is_near) continue;
      const DVec3 normal = glm::cross(at[1] - at[0], at[2] - at[0]);
      EXPECT_GT(glm::dot(normal, view.frame.origin - at[0]), 0);
    }
  }
}

}  // namespace
}  // namespace penumbra
