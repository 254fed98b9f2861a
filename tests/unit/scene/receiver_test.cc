#include "render/scene/receiver.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "render/scene/field_error.h"
#include "tests/support/shapes.h"

namespace penumbra {
namespace {

Instance Placed(MeshGeometry geometry, Affine world_from_mesh = IdentityAffine()) {
  return {
      .id = "i", .mesh = testing::MeshOf(std::move(geometry)), .world_from_mesh = world_from_mesh};
}

double AreaOf(const Parallelogram& p) { return glm::length(glm::cross(p.edge_u, p.edge_v)); }

// Every vertex has u and v in [0, 1].
void ExpectHolds(const Parallelogram& patch, const Instance& instance) {
  for (const Vec3& position : instance.mesh->positions()) {
    const DVec3 p(TransformPoint(instance.world_from_mesh, position));
    const DVec3 n = glm::cross(DVec3(patch.edge_u), DVec3(patch.edge_v));
    const glm::dmat3 frame(DVec3(patch.edge_u), DVec3(patch.edge_v), n);
    const DVec3 uv = glm::inverse(frame) * (p - DVec3(patch.origin));
    EXPECT_GE(uv.x, -1e-5);
    EXPECT_LE(uv.x, 1 + 1e-5);
    EXPECT_GE(uv.y, -1e-5);
    EXPECT_LE(uv.y, 1 + 1e-5);
    EXPECT_NEAR(uv.z * glm::length(n), 0, 1e-4);
  }
}

TEST(BoundingParallelogram, OfAPlacedSquareIsTheSquare) {
  Affine skew(Vec3(1, 0.5f, 0), Vec3(0, 1, 0), Vec3(0.3f, 0, 2), Vec3(4, 5, 6));
  const Instance instance = Placed(testing::UnitSquareGeometry(), skew);
  const auto patch = BoundingParallelogram(instance);
  ASSERT_TRUE(patch.ok()) << patch.status();
  ExpectHolds(*patch, instance);
  const Vec3 u = 2.0f * skew[0], v = 2.0f * skew[2];
  EXPECT_NEAR(AreaOf(*patch), glm::length(glm::cross(u, v)), 1e-4);
  // The front is where the faces look: z × x of a right-handed frame.
  EXPECT_GT(glm::dot(patch->normal(), glm::cross(v, u)), 0);
}

TEST(BoundingParallelogram, OfATurnedRectangleIsNoLargerThanIt) {
  const float c = std::cos(0.4f), s = std::sin(0.4f);
  MeshGeometry l_shape{
      .positions = {{0, 0, 0}, {3, 0, 0}, {3, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}},
      .indices = {0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 5},
      .normals = {},
      .uvs = {}};
  for (Vec3& p : l_shape.positions) p = Vec3(c * p.x - s * p.y, s * p.x + c * p.y, 0);
  const Instance instance = Placed(l_shape);
  const auto patch = BoundingParallelogram(instance);
  ASSERT_TRUE(patch.ok());
  ExpectHolds(*patch, instance);
  EXPECT_NEAR(AreaOf(*patch), 6, 0.05 * 6);
  EXPECT_NEAR(patch->normal().z, 1, 1e-6);
}

TEST(BoundingParallelogram, FollowsTheWindingOfAMirror) {
  const Affine mirror(Vec3(-1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(0));
  EXPECT_GT(BoundingParallelogram(Placed(testing::UnitSquareGeometry()))->normal().y, 0.99f);
  EXPECT_LT(BoundingParallelogram(Placed(testing::UnitSquareGeometry(), mirror))->normal().y,
            -0.99f);
}

TEST(BoundingParallelogram, RefusesWhatIsNotFlat) {
  for (const Instance& instance :
       {Placed(testing::UnitBoxGeometry()), Placed({}),
        Placed(testing::UnitSquareGeometry(), testing::Placed(Vec3(0), 0)),
        Placed(testing::UnitSquareGeometry(),
               Affine(Vec3(1, 0, 0), Vec3(0, 5e-7f, 0), Vec3(0, 0, 5e-7f), Vec3(0)))}) {
    const auto patch = BoundingParallelogram(instance);
    EXPECT_EQ(patch.status().code(), absl::StatusCode::kFailedPrecondition);
    EXPECT_EQ(ErrorReason(patch.status()), "NOT_PLANAR");
  }
}

TEST(Parallelogram, HasANormalHoweverSmallItIs) {
  const Parallelogram tiny{
      .origin = Vec3(0), .edge_u = Vec3(1e-15f, 0, 0), .edge_v = Vec3(0, 0, -1e-15f)};
  EXPECT_EQ(tiny.normal(), Vec3(0, 1, 0));
}

TEST(ReceiverPatch, HasTexelCentresHalfATexelIn) {
  const ReceiverPatch patch{
      .patch = {Vec3(0), Vec3(4, 0, 0), Vec3(0, 0, -2)}, .width = 4, .height = 2};
  EXPECT_EQ(patch.TexelCenter(0, 0), Vec3(0.5f, 0, -0.5f));
  EXPECT_EQ(patch.TexelCenter(3, 1), Vec3(3.5f, 0, -1.5f));
}

}  // namespace
}  // namespace penumbra
