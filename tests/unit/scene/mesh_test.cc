#include "render/scene/mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "render/scene/field_error.h"
#include "tests/support/shapes.h"

namespace penumbra {
namespace {

using ::testing::HasSubstr;

MeshGeometry Triangle() {
  return {.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
          .indices = {0, 1, 2},
          .normals = {},
          .uvs = {}};
}

void ExpectRefused(MeshGeometry geometry, absl::StatusCode code, const std::string& reason,
                   const std::string& field) {
  const auto mesh = Mesh::Create(std::move(geometry));
  ASSERT_FALSE(mesh.ok());
  EXPECT_EQ(mesh.status().code(), code);
  EXPECT_EQ(ErrorReason(mesh.status()), reason);
  EXPECT_EQ(ErrorFieldPath(mesh.status()), field);
  EXPECT_THAT(std::string(mesh.status().message()), HasSubstr(field + ": found "));
}

TEST(Mesh, RefusesWhatIsWrongAndNamesIt) {
  const auto invalid = absl::StatusCode::kInvalidArgument;
  auto nan = Triangle();
  nan.positions[1].y = std::numeric_limits<float>::quiet_NaN();
  ExpectRefused(nan, invalid, "NON_FINITE", "positions[1]");
  auto infinite = Triangle();
  infinite.normals.assign(3, Vec3(0, 0, std::numeric_limits<float>::infinity()));
  ExpectRefused(infinite, invalid, "NON_FINITE", "normals[0]");
  auto far = Triangle();
  far.positions[2].z = 1e15f;
  ExpectRefused(far, invalid, "OUT_OF_BOUNDS", "positions[2]");
  auto range = Triangle();
  range.indices[2] = 3;
  ExpectRefused(range, invalid, "INDEX_RANGE", "indices[2]");
  range.indices[0] = 0xffffffffu;
  ExpectRefused(range, invalid, "INDEX_RANGE", "indices[0]");
  auto ragged = Triangle();
  ragged.indices.push_back(0);
  ExpectRefused(ragged, invalid, "LENGTH", "indices");
  auto short_uvs = Triangle();
  short_uvs.uvs.assign(2, Vec2(0));
  ExpectRefused(short_uvs, invalid, "LENGTH", "uvs");
}

TEST(Mesh, A10RefusesMoreThanTheLimit) {
  SceneLimits limits;
  limits.max_triangles_per_mesh = 0;
  EXPECT_EQ(ErrorReason(Mesh::Create(Triangle(), limits).status()), "QUOTA_TRIANGLES");
  limits.max_vertices_per_mesh = 2;
  EXPECT_EQ(Mesh::Create(Triangle(), limits).status().code(), absl::StatusCode::kResourceExhausted);
}

TEST(Mesh, A03NamesEqualShapesAlike) {
  auto negative_zero = Triangle();
  negative_zero.positions[0] = Vec3(-0.0f);
  EXPECT_EQ((*Mesh::Create(Triangle()))->id(), (*Mesh::Create(negative_zero))->id());
  auto other = Triangle();
  other.positions[0].x = 0.5f;
  EXPECT_NE((*Mesh::Create(Triangle()))->id(), (*Mesh::Create(other))->id());
}

TEST(Mesh, A04AcceptsAndCountsDegenerateTriangles) {
  auto geometry = Triangle();
  geometry.positions.push_back({2, 0, 0});
  geometry.indices.insert(geometry.indices.end(), {0, 1, 3, 1, 1, 2});
  EXPECT_EQ((*Mesh::Create(geometry))->degenerate_triangle_count(), 2u);
  EXPECT_TRUE((*Mesh::Create({}))->bounds().empty());
}

MeshGeometry Joined(MeshGeometry a, const MeshGeometry& b, Vec3 shift, bool inside_out) {
  const auto first = static_cast<uint32_t>(a.positions.size());
  for (const Vec3& p : b.positions) a.positions.push_back(p + shift);
  for (size_t t = 0; t < b.indices.size(); t += 3) {
    for (const size_t k :
         {size_t{0}, inside_out ? size_t{2} : size_t{1}, inside_out ? size_t{1} : size_t{2}}) {
      a.indices.push_back(first + b.indices[t + k]);
    }
  }
  return a;
}

TEST(MeshClosure, TellsSolidsFromSheets) {
  const MeshGeometry box = testing::UnitBoxGeometry();
  EXPECT_EQ((*Mesh::Create(box))->closure(), MeshClosure::kClosedOutward);
  EXPECT_EQ((*Mesh::Create(testing::UnitSquareGeometry()))->closure(), MeshClosure::kOpen);
  EXPECT_EQ((*Mesh::Create({}))->closure(), MeshClosure::kOpen);

  MeshGeometry lidless = box;
  lidless.indices.resize(lidless.indices.size() - 3);
  EXPECT_EQ((*Mesh::Create(lidless))->closure(), MeshClosure::kOpen);

  EXPECT_EQ((*Mesh::Create(Joined(box, box, Vec3(5, 0, 0), false)))->closure(),
            MeshClosure::kClosedOutward);
  EXPECT_EQ((*Mesh::Create(Joined(box, box, Vec3(5, 0, 0), true)))->closure(),
            MeshClosure::kClosed);
  // Two boxes that share an edge: four faces meet there.
  EXPECT_EQ((*Mesh::Create(Joined(box, box, Vec3(2, 2, 0), false)))->closure(), MeshClosure::kOpen);
}

TEST(MeshClosure, WeldsVerticesThatWereSplitForTheirNormals) {
  MeshGeometry split;
  const MeshGeometry box = testing::UnitBoxGeometry();
  for (const uint32_t index : box.indices) {
    split.indices.push_back(static_cast<uint32_t>(split.positions.size()));
    split.positions.push_back(box.positions[index]);
  }
  EXPECT_EQ((*Mesh::Create(split))->closure(), MeshClosure::kClosedOutward);
}

}  // namespace
}  // namespace penumbra
