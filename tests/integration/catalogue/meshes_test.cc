// Rows A01 to A11 and A21 for meshes and masks, which come as bytes.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <limits>
#include <string>
#include <vector>

#include "tests/integration/catalogue/blob_bytes.h"
#include "tests/integration/catalogue/catalogue_test.h"

namespace penumbra::testing {
namespace {

using ::testing::HasSubstr;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;
constexpr auto kExhausted = absl::StatusCode::kResourceExhausted;

class MeshRowsTest : public CatalogueTest {
 protected:
  void ExpectRefusedBlob(const BlobBytes& blob, const Refusal& expected) {
    ExpectRefused([&] { return UploadBytes(*client_, blob).status(); }, expected);
  }
  // Puts a mesh into the scene, and gives the floor's shadow.
  std::vector<uint16_t> ShadowWith(const MeshGeometry& geometry, const Affine& world_from_mesh) {
    const auto mesh = MeshOf(geometry);
    mirror_.Know(mesh);
    EXPECT_EQ(client_->Upload(*mesh), absl::OkStatus());
    SceneDelta delta;
    delta.upsert_instances = {{.id = "added", .mesh = mesh, .world_from_mesh = world_from_mesh}};
    const auto result = session_->Commit(delta);
    EXPECT_FALSE(result.has_error()) << result.error().message();
    return FloorAt(result.revision()).visibility.counts;
  }
};

TEST_F(MeshRowsTest, A01NumbersThatAreNoneAreRefused) {
  for (const float bad : {kNan, kInfinity, -kInfinity}) {
    ExpectRefusedBlob(TriangleBytes({0, 1, 2}, {-1, 1, 1, 1, bad, 1, 0, 1, -1}),
                      {kInvalid, "NON_FINITE", "positions[1]"});
    const std::vector<float> corners = {-1, 1, 1, 1, 1, 1, 0, 1, -1};
    ExpectRefusedBlob(BlobBytes(kMeshMagic)
                          .Words({3, 3, 1})
                          .Floats(corners)
                          .Floats({0, 1, 0, 0, 1, 0, 0, 1, bad})
                          .Words({0, 1, 2}),
                      {kInvalid, "NON_FINITE", "normals[2]"});
    ExpectRefusedBlob(BlobBytes(kMeshMagic)
                          .Words({3, 3, 2})
                          .Floats(corners)
                          .Floats({bad, 0, 0, 0, 0, 0})
                          .Words({0, 1, 2}),
                      {kInvalid, "NON_FINITE", "uvs[0]"});
  }
}

TEST_F(MeshRowsTest, A02WhatIsTooFarIsRefusedAndWhatIsTinyIsNot) {
  for (const float far : {1.1e9f, 1e15f, -std::numeric_limits<float>::max()}) {
    ExpectRefusedBlob(TriangleBytes({0, 1, 2}, {-1, 1, 1, 1, 1, 1, 0, 1, far}),
                      {kInvalid, "OUT_OF_BOUNDS", "positions[2]"});
  }
  const float tiny = std::numeric_limits<float>::denorm_min();
  EXPECT_TRUE(
      UploadBytes(*client_, TriangleBytes({0, 1, 2}, {-1, tiny, 1, 1, -tiny, 1, 0, 1e-40f, -1}))
          .ok());
}

TEST_F(MeshRowsTest, A03ZerosOfBothSignsAreOne) {
  const auto positive = TriangleBytes({0, 1, 2}, {0, 1, 1, 1, 1, 0, 0, 1, 0});
  const auto negative = TriangleBytes({0, 1, 2}, {-0.0f, 1, 1, 1, 1, -0.0f, 0, 1, -0.0f});
  ExpectRefusedBlob(negative, {kInvalid, "HASH_MISMATCH", "header.hash"});
  const std::string name = HashOf(positive.bytes());
  EXPECT_TRUE(UploadBytes(*client_, negative.bytes(), name).ok()) << "named as with +0";
  EXPECT_TRUE(client_->FindMissing({name})->empty());
  EXPECT_EQ(client_
                ->Download(MeshOf({.positions = {{0, 1, 1}, {1, 1, 0}, {0, 1, 0}},
                                   .indices = {0, 1, 2},
                                   .normals = {},
                                   .uvs = {}})
                               ->id())
                .value(),
            positive.bytes());
  // The same of what deltas bring.
  const auto there = session_->Commit(MoveBox({0, 1, 0}));
  const auto again = session_->Commit(MoveBox({-0.0f, 1, -0.0f}));
  EXPECT_EQ(again.content_hash(), there.content_hash());
}

TEST_F(MeshRowsTest, A04TrianglesOfNoAreaAreCountedAndCastNothing) {
  const auto before = FloorAt(1).visibility.counts;
  // Three corners on a line, and one corner twice.
  const auto stored =
      UploadBytes(*client_, TriangleBytes({0, 1, 2, 0, 0, 1}, {-1, 2, 0, 0, 2, 0, 1, 2, 0}));
  ASSERT_TRUE(stored.ok()) << stored.status();
  EXPECT_EQ(stored->blobs(0).degenerate_triangle_count(), 2u);
  const MeshGeometry lines{.positions = {{-1, 2, 0}, {0, 2, 0}, {1, 2, 0}},
                           .indices = {0, 1, 2, 0, 0, 1},
                           .normals = {},
                           .uvs = {}};
  EXPECT_EQ(ShadowWith(lines, Placed({0, 0, 0})), before);
}

TEST_F(MeshRowsTest, A05IndicesOfNoVertexAreRefused) {
  ExpectRefusedBlob(TriangleBytes({0, 1, 3}), {kInvalid, "INDEX_RANGE", "indices[2]"});
  ExpectRefusedBlob(TriangleBytes({0xffffffffu, 1, 2}), {kInvalid, "INDEX_RANGE", "indices[0]"});
  ExpectRefusedBlob(TriangleBytes({0, 0, 0}, {}), {kInvalid, "INDEX_RANGE", "indices[0]"});
}

TEST_F(MeshRowsTest, A06PartsOfATriangleOrOfAVertexAreRefused) {
  ExpectRefusedBlob(TriangleBytes({0, 1, 2, 0}), {kInvalid, "LENGTH", "indices"});
  ExpectRefusedBlob(BlobBytes(kMeshMagic).Words({3, 0, 0}).Floats({0, 0, 0, 1, 0, 0, 0, 1}),
                    {kInvalid, "LENGTH", "blob"});
}

// The counts are multiplied in 64 bits, which they do not fill, and compared with what is there.
TEST_F(MeshRowsTest, A07CountsWhoseProductsOverflowAreRefusedBeforeAnythingIsAllocated) {
  for (const uint32_t count : {0xffffffffu, 0x80000000u, 0x40000000u, 0x15555556u}) {
    for (const std::vector<uint32_t>& header :
         {std::vector<uint32_t>{count, 3, 0}, {3, count, 0}, {count, count, 3}}) {
      ExpectRefusedBlob(BlobBytes(kMeshMagic).Words(header).Floats({0, 0, 0, 1, 0, 0, 0, 1, 0}),
                        {kInvalid, "LENGTH", "blob"});
    }
  }
  ExpectRefusedBlob(BlobBytes(kMaskMagic).Words({0x10000u, 0x10000u}).Text("x"),
                    {kInvalid, "LENGTH", "blob"});
  std::vector<v1::UploadBlobRequest> endless(1);
  endless[0].mutable_header()->set_hash(std::string(32, 'h'));
  endless[0].mutable_header()->set_size_bytes(~uint64_t{0});
  ExpectRefused([&] { return client_->Upload(endless).status(); },
                {kExhausted, "QUOTA_BLOB_BYTES", "header.size_bytes"});
}

TEST_F(MeshRowsTest, A08MoreOrFewerBytesThanTheCountsSayAreRefused) {
  ExpectRefusedBlob(TriangleBytes().Text("x"), {kInvalid, "LENGTH", "blob"});
  const std::string whole = TriangleBytes().bytes();
  for (const size_t size : {size_t{20}, size_t{21}, whole.size() - 1}) {
    ExpectRefused(
        [&] {
          const std::string cut = whole.substr(0, size);
          return UploadBytes(*client_, cut, HashOf(cut)).status();
        },
        {kInvalid, "LENGTH", "blob"});
  }
}

TEST_F(MeshRowsTest, A09MeshesOfNothingAreAcceptedAndCastNothing) {
  const auto before = FloorAt(1).visibility.counts;
  EXPECT_EQ(ShadowWith({}, Placed({0, 2, 0})), before);
  EXPECT_EQ(ShadowWith({.positions = {{1, 2, 3}}, .indices = {}, .normals = {}, .uvs = {}},
                       Placed({0, 2, 0})),
            before);
}

TEST_F(MeshRowsTest, A21MasksWithoutTheTexelsThatTheyPromiseAreRefusedAtOnce) {
  const std::string hundred(100, '\x7f');
  const auto start = std::chrono::steady_clock::now();
  ExpectRefusedBlob(BlobBytes(kMaskMagic).Words({65535, 65535}).Text(hundred),
                    {kInvalid, "LENGTH", "blob"});
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::milliseconds(500));
  ExpectRefusedBlob(BlobBytes(kMaskMagic).Words({10, 10}).Text(hundred.substr(1)),
                    {kInvalid, "LENGTH", "blob"});
  ExpectRefusedBlob(BlobBytes(kMaskMagic).Words({100}), {kInvalid, "BLOB_FORMAT", "blob"});
  ExpectRefusedBlob(BlobBytes("\x89PNG").Words({10, 10}).Text(hundred),
                    {kInvalid, "BLOB_FORMAT", "blob"});
  ExpectRefusedBlob(BlobBytes(kMeshMagic).Words({3, 3, 4}).Text(hundred),
                    {kInvalid, "BLOB_FORMAT", "blob"});
}

class SmallScenesTest : public MeshRowsTest {
 protected:
  SmallScenesTest() {
    options_.limits.scene.max_triangles_per_mesh = 20;
    options_.limits.scene.max_vertices_per_mesh = 30;
    options_.limits.scene.max_triangles_per_scene = 30;
    options_.limits.scene.max_lights = 4;
    options_.limits.scene.max_instances = 8;
  }
};

TEST_F(SmallScenesTest, A10MeshesAndScenesOverTheLimitAreRefusedWithIt) {
  std::vector<uint32_t> indices;
  for (int i = 0; i < 21; ++i) indices.insert(indices.end(), {0, 1, 2});
  ExpectRefusedBlob(TriangleBytes(indices), {kExhausted, "QUOTA_TRIANGLES", "indices"});
  ExpectRefusedBlob(TriangleBytes({}, std::vector<float>(31 * 3)),
                    {kExhausted, "QUOTA_VERTICES", "positions"});
  SceneDelta boxes;  // 12 triangles each; one is there
  boxes.upsert_instances = {Box({1, 1, 0}, "second"), Box({-1, 1, 0}, "third")};
  ExpectRefused(ToProto(boxes), {kExhausted, "QUOTA_SCENE_TRIANGLES", "upsert_instances"});
  EXPECT_THAT(session_->Commit(boxes).error().message(),
              ::testing::AllOf(HasSubstr("found 36"), HasSubstr("at most 30")));
}

TEST_F(SmallScenesTest, A11MoreObjectsThanASceneHoldsAreRefusedByTheirNumber) {
  SceneDelta lights, instances;
  for (int i = 0; i < 4; ++i) {
    lights.upsert_lights.push_back({.id = "point" + std::to_string(i), .shape = PointLight{}});
  }
  ExpectRefused(ToProto(lights), {kExhausted, "QUOTA_LIGHTS", "upsert_lights"});
  const auto nothing = MeshOf({});
  ASSERT_EQ(client_->Upload(*nothing), absl::OkStatus());
  for (int i = 0; i < 8; ++i) {
    instances.upsert_instances.push_back({.id = "no" + std::to_string(i), .mesh = nothing});
  }
  ExpectRefused(ToProto(instances), {kExhausted, "QUOTA_INSTANCES", "upsert_instances"});
}

}  // namespace
}  // namespace penumbra::testing
