#include "render/scene/planar_surfaces.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "render/scene/field_error.h"
#include "render/scene/scene.h"
#include "render/scene/surface_receivers.h"
#include "tests/support/shapes.h"

namespace penumbra {
namespace {

using ::testing::ElementsAre;

// A grid of n × n squares, two triangles each, over [-1, 1]² at y = 1, with vertices of its own.
void AddSplitTop(int n, MeshGeometry& geometry) {
  const auto first = static_cast<uint32_t>(geometry.positions.size());
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      geometry.positions.emplace_back(-1 + 2.0f * i / n, 1, 1 - 2.0f * j / n);
    }
  }
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const uint32_t a = first + j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      geometry.indices.insert(geometry.indices.end(), {a, b, d, a, d, c});
    }
  }
}

MeshGeometry BoxWithSplitTop(int n) {
  MeshGeometry box = testing::UnitBoxGeometry();
  std::vector<uint32_t> sides;
  for (size_t t = 0; t < box.indices.size(); t += 3) {
    const bool is_top = box.positions[box.indices[t]].y > 0 &&
                        box.positions[box.indices[t + 1]].y > 0 &&
                        box.positions[box.indices[t + 2]].y > 0;
    if (!is_top) sides.insert(sides.end(), &box.indices[t], &box.indices[t] + 3);
  }
  box.indices = sides;
  AddSplitTop(n, box);
  return box;
}

MeshGeometry Sphere(int rings) {
  MeshGeometry sphere;
  for (int r = 0; r <= rings; ++r) {
    for (int s = 0; s < 2 * rings; ++s) {
      const double polar = std::numbers::pi * r / rings, around = std::numbers::pi * s / rings;
      sphere.positions.emplace_back(std::sin(polar) * std::cos(around), std::cos(polar),
                                    std::sin(polar) * std::sin(around));
    }
  }
  const auto sides = static_cast<uint32_t>(2 * rings);
  for (uint32_t r = 0; r < static_cast<uint32_t>(rings); ++r) {
    for (uint32_t s = 0; s < sides; ++s) {
      const uint32_t a = r * sides + s, b = r * sides + (s + 1) % sides;
      sphere.indices.insert(sphere.indices.end(), {a, a + sides, b, b, a + sides, b + sides});
    }
  }
  return sphere;
}

TEST(PlanarSurfaces, ABoxHasSix) {
  const auto box = testing::MeshOf(testing::UnitBoxGeometry());
  EXPECT_EQ(box->planar_surfaces().count(), 6u);
  for (uint32_t t = 0; t < 12; ++t) {
    const auto members = box->planar_surfaces().Triangles(*box->planar_surfaces().SurfaceOf(t));
    EXPECT_THAT(members, ElementsAre(t / 2 * 2, t / 2 * 2 + 1));
  }
  EXPECT_FALSE(box->planar_surfaces().SurfaceOf(12));
}

TEST(PlanarSurfaces, AFaceOfTwoHundredTrianglesIsOne) {
  const auto box = testing::MeshOf(BoxWithSplitTop(10));
  EXPECT_EQ(box->triangle_count(), 210u);
  const PlanarSurfaces& surfaces = box->planar_surfaces();
  EXPECT_EQ(surfaces.count(), 6u);
  EXPECT_EQ(surfaces.Triangles(*surfaces.SurfaceOf(100)).size(), 200u);
}

TEST(PlanarSurfaces, AreJoinedByEdgesOnly) {
  // Two squares of one plane that touch in a corner, and a sheet with two sides.
  const auto apart = testing::MeshOf(
      {.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {2, 1, 0}, {2, 2, 0}, {1, 2, 0}},
       .indices = {0, 1, 2, 0, 2, 3, 2, 4, 5, 2, 5, 6}});
  EXPECT_EQ(apart->planar_surfaces().count(), 2u);
  const auto sheet = testing::MeshOf({.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}},
                                      .indices = {0, 1, 2, 0, 2, 3, 2, 1, 0, 3, 2, 0}});
  EXPECT_EQ(sheet->planar_surfaces().count(), 2u);
  EXPECT_THAT(sheet->planar_surfaces().Triangles(0), ElementsAre(0, 1));
  EXPECT_THAT(sheet->planar_surfaces().Triangles(1), ElementsAre(2, 3));
}

TEST(PlanarSurfaces, LeavesOutWhatHasNoArea) {
  const auto mesh = testing::MeshOf(
      {.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}}, .indices = {0, 1, 2, 0, 1, 3}});
  EXPECT_EQ(mesh->planar_surfaces().count(), 1u);
  EXPECT_FALSE(testing::MeshOf({})->planar_surfaces().SurfaceOf(0));
  EXPECT_EQ(testing::MeshOf({})->planar_surfaces().count(), 0u);
}

// However fine a sphere is, no surface of it leaves the plane of its largest triangle by more than
// the tolerance, and every triangle with an area belongs to just one.
TEST(PlanarSurfaces, ACurvedSurfaceFallsIntoFlatPieces) {
  for (const int rings : {8, 200}) {
    const auto mesh = testing::MeshOf(Sphere(rings));
    const PlanarSurfaces& surfaces = mesh->planar_surfaces();
    EXPECT_GT(surfaces.count(), 100u);
    const double tolerance = 2e-5 * 2 * std::sqrt(3.0) * 1.001;
    std::set<uint32_t> seen;
    for (size_t s = 0; s < surfaces.count(); ++s) {
      std::vector<DVec3> corners;
      double largest = 0;
      DVec3 normal(0.0), on_plane(0.0);
      for (const uint32_t t : surfaces.Triangles(s)) {
        EXPECT_TRUE(seen.insert(t).second);
        EXPECT_EQ(surfaces.SurfaceOf(t), s);
        for (int k = 0; k < 3; ++k) {
          corners.emplace_back(mesh->positions()[mesh->indices()[3 * t + k]]);
        }
        const DVec3* c = &corners[corners.size() - 3];
        const DVec3 cross = glm::cross(c[1] - c[0], c[2] - c[0]);
        if (glm::length(cross) <= largest) continue;
        largest = glm::length(cross);
        normal = glm::normalize(cross);
        on_plane = c[0];
      }
      for (const DVec3& p : corners) {
        ASSERT_LE(std::abs(glm::dot(p - on_plane, normal)), tolerance) << s;
      }
    }
    // Those without area join what they touch; at the poles they touch all that is there.
    EXPECT_EQ(seen.size(), mesh->triangle_count());
  }
}

Instance Placed(const std::string& id, std::shared_ptr<const Mesh> mesh, Affine place) {
  return {.id = id, .mesh = std::move(mesh), .world_from_mesh = place};
}

SceneDelta TwoBoxes() {
  const auto box = testing::MeshOf(testing::UnitBoxGeometry());
  SceneDelta delta;
  delta.upsert_instances = {Placed("a", box, testing::Placed(Vec3(0), Vec3(1, 2, 3))),
                            Placed("b", box, testing::Placed(Vec3(9, 0, 0), 0.5f)),
                            Placed("c", box, testing::Placed(Vec3(0, 9, 0)))};
  delta.upsert_instances[2].receives = false;
  return delta;
}

TEST(SurfaceReceivers, AreListedByTheirAreaInTheWorld) {
  const auto scene = Scene::Empty("s")->Apply(TwoBoxes()).value();
  const auto found = FindPlanarSurfaces(scene->instances(), 0);
  ASSERT_EQ(found.size(), 12u);
  EXPECT_NEAR(found[0].area_m2, 24, 1e-5);  // 4 by 6
  EXPECT_NEAR(found[2].area_m2, 12, 1e-5);
  EXPECT_NEAR(found[4].area_m2, 8, 1e-5);
  EXPECT_NEAR(found[11].area_m2, 1, 1e-6);
  EXPECT_EQ(found[5].instance_id, "a");
  EXPECT_EQ(found[6].instance_id, "b");
  EXPECT_LT(found[0].triangle, found[1].triangle) << "equals by their place in the mesh";
  EXPECT_EQ(FindPlanarSurfaces(scene->instances(), 10).size(), 4u);
  EXPECT_EQ(FindPlanarSurfaces(scene->instances(), 0, 3).size(), 3u);
}

TEST(SurfaceReceivers, OneFieldOfADeltaMakesThemAll) {
  SceneDelta delta = TwoBoxes();
  delta.receive_on_planar_surfaces = {.min_area_m2 = 10, .id_prefix = "wall."};
  EXPECT_FALSE(SceneDelta{.receive_on_planar_surfaces = PlanarSurfaceRequest{}}.empty());
  const auto scene = Scene::Empty("s")->Apply(delta).value();
  std::vector<std::string> ids;
  for (const auto& [id, receiver] : scene->receivers()) {
    ids.push_back(id);
    const auto patch = scene->ResolveReceiver(id);
    ASSERT_TRUE(patch.ok());
    EXPECT_EQ(CoverRegion(*patch->region, patch->width, patch->height), nullptr);
    EXPECT_EQ(std::max(patch->width, patch->height), 256u);
  }
  EXPECT_THAT(ids, ElementsAre("wall.a.10", "wall.a.4", "wall.a.6", "wall.a.8"));
  // Asked for again it changes nothing but the revision; the receivers follow their instance.
  SceneDelta again;
  again.receive_on_planar_surfaces = delta.receive_on_planar_surfaces;
  EXPECT_EQ((*scene->Apply(again))->content_hash(), scene->content_hash());
  SceneDelta move;
  move.upsert_instances = {delta.upsert_instances[0]};
  move.upsert_instances[0].world_from_mesh[3] += Vec3(0, 0, 7);
  const auto moved = scene->Apply(move).value();
  EXPECT_FLOAT_EQ(moved->ResolveReceiver("wall.a.8")->patch.origin.z,
                  scene->ResolveReceiver("wall.a.8")->patch.origin.z + 7);
}

TEST(SurfaceReceivers, TooManyAreRefusedAndNothingIsMade) {
  const auto refused = [](PlanarSurfaceRequest request, const SceneLimits& limits) {
    SceneDelta delta = TwoBoxes();
    delta.receive_on_planar_surfaces = std::move(request);
    const auto status = Scene::Empty("s")->Apply(delta, limits).status();
    EXPECT_THAT(ErrorFieldPath(status), ::testing::StartsWith("receive_on_planar_surfaces"));
    return ErrorReason(status);
  };
  EXPECT_EQ(refused({}, {.max_receivers = 11}), "QUOTA_RECEIVERS");
  EXPECT_EQ(refused({}, {.max_surface_triangles = 11}), "QUOTA_SURFACE_TRIANGLES");
  EXPECT_EQ(refused({.min_area_m2 = -1}, {}), "RANGE");
  EXPECT_EQ(refused({.min_area_m2 = std::nan("")}, {}), "NON_FINITE");
  EXPECT_EQ(refused({.texels_per_metre = 1e9f}, {}), "RANGE");
  EXPECT_EQ(refused({.max_receivers = 5000}, {}), "RANGE");
  EXPECT_EQ(refused({.id_prefix = "a b"}, {}), "BAD_ID");
  SceneDelta few = TwoBoxes();
  few.receive_on_planar_surfaces = PlanarSurfaceRequest{.max_receivers = 11};
  EXPECT_EQ((*Scene::Empty("s")->Apply(few, {.max_receivers = 11}))->receivers().size(), 11u);
}

TEST(SurfaceReceivers, LongIdsAreCutByHash) {
  const std::string longest(128, 'x'), other = std::string(127, 'x') + "y";
  SceneDelta delta = TwoBoxes();
  delta.upsert_instances[0].id = longest;
  delta.upsert_instances[1].id = other;
  delta.receive_on_planar_surfaces = PlanarSurfaceRequest{};
  const auto scene = Scene::Empty("s")->Apply(delta);
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ((*scene)->receivers().size(), 12u);
}

TEST(SurfaceReceivers, ASurfaceThatIsNotThereIsRefusedByField) {
  SceneDelta delta = TwoBoxes();
  delta.upsert_receivers = {{.id = "r", .shape = PlanarSurface{"a", 12}}};
  auto status = Scene::Empty("s")->Apply(delta).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(ErrorReason(status), "NOT_PLANAR");
  EXPECT_EQ(ErrorFieldPath(status), "upsert_receivers[0].triangle");
  delta.upsert_receivers[0].shape = PlanarSurface{"ghost", 0};
  status = Scene::Empty("s")->Apply(delta).status();
  EXPECT_EQ(ErrorReason(status), "MISSING_INSTANCE");
  EXPECT_EQ(ErrorFieldPath(status), "upsert_receivers[0].instance_id");
}

}  // namespace
}  // namespace penumbra
