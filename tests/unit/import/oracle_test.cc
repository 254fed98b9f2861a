// Models by other authors, against decodings by other programs and numbers worked out otherwise.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "client/import/import_scene.h"
#include "tests/unit/import/third_party_scenes.h"

namespace penumbra {
namespace {

using OracleTest = ThirdPartyScenes;

ImportedScene Read(const std::string& name) {
  const auto scene = ImportScene(ScenesFolder() / name);
  EXPECT_TRUE(scene.ok()) << scene.status();
  return scene.ok() ? *scene : ImportedScene{};
}

// All triangles in world space, each from its least corner on, the least first: two files that hold
// the same triangles in any order give the same list.
std::vector<std::array<float, 9>> SortedTriangles(const ImportedScene& scene) {
  std::vector<std::array<float, 9>> triangles;
  for (const Instance& instance : scene.instances) {
    const auto indices = instance.mesh->indices();
    for (size_t i = 0; i < indices.size(); i += 3) {
      std::array<std::array<float, 3>, 3> corners;
      for (size_t k = 0; k < 3; ++k) {
        const Vec3 p =
            TransformPoint(instance.world_from_mesh, instance.mesh->positions()[indices[i + k]]);
        corners[k] = {p.x, p.y, p.z};
      }
      std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
      triangles.push_back({corners[0][0], corners[0][1], corners[0][2], corners[1][0],
                           corners[1][1], corners[1][2], corners[2][0], corners[2][1],
                           corners[2][2]});
    }
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

struct Measures {
  size_t triangles = 0;
  double area = 0.0;
  DVec3 moment{0.0};  // ∫ position dA

  explicit Measures(const ImportedScene& scene) {
    for (const auto& t : SortedTriangles(scene)) {
      const DVec3 a(t[0], t[1], t[2]), b(t[3], t[4], t[5]), c(t[6], t[7], t[8]);
      const double piece = 0.5 * glm::length(glm::cross(b - a, c - a));
      area += piece;
      moment += piece * (a + b + c) / 3.0;
      ++triangles;
    }
  }
};

void ExpectSameSurface(const ImportedScene& found, const ImportedScene& expected,
                       double tolerance) {
  const Measures f(found), e(expected);
  EXPECT_EQ(f.triangles, e.triangles);
  const double size = glm::length(DVec3(Bounds(expected).extent()));
  EXPECT_NEAR(f.area / e.area, 1.0, tolerance);
  EXPECT_LT(glm::distance(f.moment / f.area, e.moment / e.area), tolerance * size);
  EXPECT_LT(glm::distance(Bounds(found).min, Bounds(expected).min), tolerance * size);
  EXPECT_LT(glm::distance(Bounds(found).max, Bounds(expected).max), tolerance * size);
}

TEST_F(OracleTest, MeshoptDecodesToTheDecodedFile) {
  EXPECT_EQ(SortedTriangles(Read("bunny-meshopt-144k/bunny.glb")),
            SortedTriangles(Read("bunny-meshopt-144k/bunny-144k.decoded.ply")));
}

TEST_F(OracleTest, QuantisedNodesDecodeToTheDecodedFile) {
  ExpectSameSurface(Read("bridge-garden/scene.glb"),
                    Read("bridge-garden/bridge-garden.decoded.ply"), 1e-5);
}

// The same model twice: Draco, and plain.
TEST_F(OracleTest, DracoMatchesThePlainFile) {
  for (const std::string name : {"CesiumMilkTruck", "MorphPrimitivesTest"}) {
    const std::string folder = "gltf-features/khronos/" + name;
    ExpectSameSurface(Read(folder + "/glTF-Draco/" + name + ".gltf"),
                      Read(folder + "/glTF/" + name + ".gltf"), 2e-3);
  }
}

TEST_F(OracleTest, QuantisedMatchesThePlainFile) {
  const std::string folder = "gltf-features/khronos/AnimatedMorphCube";
  ExpectSameSurface(Read(folder + "/glTF-Quantized/AnimatedMorphCube.gltf"),
                    Read(folder + "/glTF/AnimatedMorphCube.gltf"), 1e-4);
}

TEST_F(OracleTest, MeshoptMatchesTheObjItWasMadeFrom) {
  const std::string folder = "gltf-features/compressed/meshoptimizer/pirate";
  ExpectSameSurface(Read(folder + ".glb"), Read(folder + ".obj"), 1e-3);
}

TEST_F(OracleTest, CompressedBoxesAreUnitCubes) {
  for (const char* name : {"BoxDraco.gltf", "BoxMeshopt.gltf", "BoxMeshopt.glb"}) {
    const Measures box(Read(std::string("gltf-features/compressed/gltf-transform/") + name));
    EXPECT_EQ(box.triangles, 12u) << name;
    EXPECT_NEAR(box.area, 6.0, 1e-2) << name;
  }
}

// 125 cubes on a 5×5×5 grid, by the sample's own description.
TEST_F(OracleTest, InstancingPlaces125Cubes) {
  const ImportedScene scene =
      Read("gltf-features/khronos/SimpleInstancing/glTF/SimpleInstancing.gltf");
  ASSERT_EQ(scene.instances.size(), 125u);
  for (const Instance& instance : scene.instances) {
    EXPECT_EQ(instance.mesh.get(), scene.instances[0].mesh.get());
  }
}

// The square strip, fan and list of this sample cover 1 m² each.
TEST_F(OracleTest, PrimitiveModesCoverTheSameArea) {
  const ImportedScene scene =
      Read("gltf-features/khronos/MeshPrimitiveModes/glTF/MeshPrimitiveModes.gltf");
  ASSERT_EQ(scene.instances.size(), 3u);
  std::vector<double> areas;
  for (const Instance& instance : scene.instances) {
    areas.push_back(Measures(ImportedScene{.instances = {instance}}).area);
  }
  EXPECT_NEAR(areas[1] / areas[0], 1.0, 0.01);
  EXPECT_NEAR(areas[2] / areas[0], 1.0, 0.01);
}

// From the specification's tutorial: three vertices are lifted by the sparse values, up to y = 4.
TEST_F(OracleTest, SparseAccessorsLiftTheirVertices) {
  const ImportedScene scene =
      Read("gltf-features/khronos/SimpleSparseAccessor/glTF/SimpleSparseAccessor.gltf");
  EXPECT_EQ(Bounds(scene).max, Vec3(6, 4, 0));
  EXPECT_EQ(Bounds(scene).min, Vec3(0, 0, 0));
}

// The light of the Cornell box: corners and radiance as in its OBJ and MTL files.
TEST_F(OracleTest, CornellBoxHasItsLight) {
  const ImportedScene scene = Read("cornell-box/original-data/cornell_box.obj");
  ASSERT_EQ(scene.lights.size(), 1u);
  const auto light = std::get<RectangleLight>(scene.lights[0].shape);
  EXPECT_EQ(light.radiance, Vec3(20));
  const Vec3 normal = glm::cross(light.edge_u, light.edge_v);
  EXPECT_NEAR(normal.y, -130.0f * 105.0f, 1.0f);
  EXPECT_NEAR(light.corner.y, 548.0f, 1e-3f);
}

TEST_F(OracleTest, TheDragonIsWhole) {
  const ImportedScene scene = Read("stanford-dragon-res2/dragon_vrip_res2.ply");
  ASSERT_EQ(scene.instances.size(), 1u);
  EXPECT_EQ(scene.instances[0].mesh->vertex_count(), 100'250u);
  EXPECT_EQ(scene.instances[0].mesh->triangle_count(), 202'520u);
}

TEST_F(OracleTest, VersionsOfCodecsThatAreNotKnownSaySo) {
  const auto scene = ImportScene(
      ScenesFolder() /
      "gltf-features/compressed/loaders.gl/MeshoptCubeTest/glTF-Meshopt/MeshoptCubeTest.gltf");
  EXPECT_EQ(scene.status().code(), absl::StatusCode::kUnimplemented);
  EXPECT_THAT(std::string(scene.status().message()),
              testing::HasSubstr("found version 1 of the ATTRIBUTES codec"));
}

}  // namespace
}  // namespace penumbra
