#include "server/scene_store/blob_store.h"

#include <gtest/gtest.h>

#include <chrono>
#include <optional>
#include <string>

#include "render/scene/field_error.h"
#include "tests/support/scarce_memory.h"
#include "tests/support/shapes.h"

namespace penumbra {
namespace {

// A triangle that differs from any other `index`.
std::shared_ptr<const Mesh> Triangle(float index) {
  return testing::MeshOf({.positions = {{index, 0, 0}, {index, 1, 0}, {index, 0, 1}},
                          .indices = {0, 1, 2},
                          .normals = {},
                          .uvs = {}});
}

class BlobStoreTest : public ::testing::Test {
 protected:
  static uint64_t TriangleBytes() { return EncodeBlob(Triangle(0)->geometry()).size(); }

  ServerLimits ThreeTriangles() {
    ServerLimits limits;
    limits.max_blob_store_bytes =
        4 * TriangleBytes() - 1;  // a blob counts twice while it is stored
    return limits;
  }

  absl::Status Store(BlobStore& store, const Mesh& mesh) {
    const auto bytes = EncodeBlob(mesh.geometry());
    auto upload = store.Begin(mesh.id(), bytes.size());
    if (!upload.ok()) return upload.status();
    const std::string data(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (auto status = (*upload)->Append(data); !status.ok()) return status;
    return (*upload)->Finish().status();
  }

  std::chrono::steady_clock::time_point now_{std::chrono::hours(1)};
};

TEST_F(BlobStoreTest, KeepsWhatItsContentNames) {
  BlobStore store({});
  const auto mesh = Triangle(1);
  EXPECT_EQ(store.FindMesh(mesh->id()), nullptr);
  ASSERT_EQ(Store(store, *mesh), absl::OkStatus());
  EXPECT_TRUE(store.Contains(mesh->id()));
  ASSERT_NE(store.FindMesh(mesh->id()), nullptr);
  EXPECT_EQ(store.FindMesh(mesh->id())->id(), mesh->id());
  EXPECT_EQ(store.FindMask(mesh->id()), nullptr) << "it is a mesh";
  ASSERT_EQ(Store(store, *mesh), absl::OkStatus()) << "twice is once";
  EXPECT_EQ(store.blob_count(), 1u);
  EXPECT_EQ(store.blob_bytes(), TriangleBytes());
}

// Messages fit into what is left, meshes do not.
TEST_F(BlobStoreTest, MemoryThatIsNotThereIsARefusal) {
  constexpr size_t kLittle = 4096;
  MeshGeometry geometry = Triangle(1)->geometry();
  geometry.positions.resize(3000, Vec3(1));
  const auto mesh = Mesh::Create(geometry).value();
  BlobStore store({});
  const auto bytes = EncodeBlob(mesh->geometry());
  const std::string data(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  {
    auto upload = store.Begin(mesh->id(), bytes.size()).value();
    const testing::ScarceMemory scarce(kLittle);
    const auto status = upload->Append(data);
    EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
    EXPECT_EQ(ErrorReason(status), "OUT_OF_MEMORY");
  }
  {
    auto upload = store.Begin(mesh->id(), bytes.size()).value();
    ASSERT_EQ(upload->Append(data), absl::OkStatus());
    const testing::ScarceMemory scarce(kLittle);
    EXPECT_EQ(upload->Finish().status().code(), absl::StatusCode::kResourceExhausted);
  }
  EXPECT_EQ(store.blob_bytes(), 0u);
  EXPECT_EQ(Store(store, *mesh), absl::OkStatus());
}

TEST_F(BlobStoreTest, WhatIsBeingSentIsInUse) {
  BlobStore store(ThreeTriangles(), [this] { return now_; });
  EXPECT_FALSE(store.FindBlob(Triangle(0)->id()));
  for (int i = 0; i < 3; ++i) {
    ASSERT_EQ(Store(store, *Triangle(static_cast<float>(i))), absl::OkStatus());
  }
  std::optional<EncodedBlob> sending(store.FindBlob(Triangle(0)->id()).value());
  now_ += std::chrono::minutes(2);
  ASSERT_EQ(Store(store, *Triangle(3)), absl::OkStatus());
  EXPECT_TRUE(store.Contains(Triangle(0)->id()));
  sending.reset();
  now_ += std::chrono::minutes(2);
  for (int i = 4; i < 7; ++i) {
    ASSERT_EQ(Store(store, *Triangle(static_cast<float>(i))), absl::OkStatus());
  }
  EXPECT_FALSE(store.Contains(Triangle(0)->id()));
}

TEST_F(BlobStoreTest, UploadsReserveAndGiveBack) {
  BlobStore store({});
  {
    const auto upload = store.Begin(Triangle(1)->id(), 1000);
    ASSERT_TRUE(upload.ok());
    EXPECT_EQ(store.blob_bytes(), 1000u);
    EXPECT_EQ(ErrorReason((*upload)->Append(std::string(1001, 'x'))), "LENGTH");
    EXPECT_EQ(ErrorReason((*upload)->Finish().status()), "LENGTH");
  }
  EXPECT_EQ(store.blob_bytes(), 0u);
}

TEST_F(BlobStoreTest, AFullStoreDropsTheOldestThatNobodyUses) {
  BlobStore store(ThreeTriangles(), [this] { return now_; });
  for (int i = 0; i < 3; ++i) {
    ASSERT_EQ(Store(store, *Triangle(static_cast<float>(i))), absl::OkStatus());
    now_ += std::chrono::seconds(1);
  }
  EXPECT_EQ(ErrorReason(Store(store, *Triangle(3))), "QUOTA_BLOB_BYTES")
      << "nothing is old enough to go";
  const auto in_use = store.FindMesh(Triangle(0)->id());
  now_ += std::chrono::minutes(2);
  EXPECT_EQ(Store(store, *Triangle(3)), absl::OkStatus());
  EXPECT_TRUE(store.Contains(Triangle(0)->id())) << "the oldest, but a scene uses it";
  EXPECT_FALSE(store.Contains(Triangle(1)->id()));
  EXPECT_TRUE(store.Contains(Triangle(2)->id()));
}

TEST_F(BlobStoreTest, AskingForABlobKeepsIt) {
  BlobStore store(ThreeTriangles(), [this] { return now_; });
  for (int i = 0; i < 3; ++i) {
    ASSERT_EQ(Store(store, *Triangle(static_cast<float>(i))), absl::OkStatus());
  }
  now_ += std::chrono::minutes(2);
  EXPECT_TRUE(store.Contains(Triangle(1)->id()));
  EXPECT_EQ(Store(store, *Triangle(3)), absl::OkStatus());
  EXPECT_TRUE(store.Contains(Triangle(1)->id()));
}

}  // namespace
}  // namespace penumbra
