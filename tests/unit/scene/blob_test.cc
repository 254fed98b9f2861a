#include "render/scene/blob.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "render/scene/field_error.h"
#include "tests/support/shapes.h"

namespace penumbra {
namespace {

using ::testing::HasSubstr;

TEST(Blob, ComesBackAsItWas) {
  for (MeshGeometry geometry :
       {testing::UnitBoxGeometry(), testing::UnitSquareGeometry(), MeshGeometry{}}) {
    if (geometry.positions.size() == 4) geometry.normals.assign(4, Vec3(0, 1, 0));
    const auto mesh = *Mesh::Create(geometry);
    const auto bytes = EncodeBlob(mesh->geometry());
    EXPECT_EQ(Sha256(bytes), mesh->id());
    const auto back = DecodeBlob(bytes);
    ASSERT_TRUE(back.ok()) << back.status();
    const auto& same = std::get<std::shared_ptr<const Mesh>>(*back);
    EXPECT_EQ(same->id(), mesh->id());
    EXPECT_EQ(same->geometry().indices, geometry.indices);
    EXPECT_EQ(same->geometry().positions, geometry.positions);
    EXPECT_EQ(same->geometry().uvs, geometry.uvs);
    EXPECT_EQ(same->geometry().normals, geometry.normals);
  }
  const auto mask = *AlphaMask::Create(3, 2, {0, 50, 100, 150, 200, 250});
  const auto back = DecodeBlob(EncodeBlob(*mask));
  ASSERT_TRUE(back.ok());
  EXPECT_EQ(std::get<std::shared_ptr<const AlphaMask>>(*back)->id(), mask->id());
}

TEST(Blob, IsReadInPiecesWhereItLies) {
  MeshGeometry square = testing::UnitSquareGeometry();
  square.normals.assign(4, Vec3(0, 1, 0));
  const auto mesh = *Mesh::Create(square);
  const auto mask = *AlphaMask::Create(3, 2, {0, 50, 100, 150, 200, 250});
  for (const auto& [content, expected] :
       {std::pair{BlobContent(mesh), EncodeBlob(mesh->geometry())},
        std::pair{BlobContent(mask), EncodeBlob(*mask)}}) {
    EncodedBlob first(content);
    const EncodedBlob blob = std::move(first);
    ASSERT_EQ(blob.size(), expected.size());
    for (const size_t step : {size_t{1}, size_t{7}, size_t{20}, expected.size()}) {
      std::vector<std::byte> bytes(expected.size());
      for (size_t at = 0; at < bytes.size(); at += step) {
        blob.CopyTo(bytes.data() + at, at, std::min(step, bytes.size() - at));
      }
      EXPECT_EQ(bytes, expected) << step;
    }
  }
}

TEST(Blob, A08RefusesEveryTruncationAndAppendage) {
  auto bytes = EncodeBlob(testing::UnitSquareGeometry());
  for (size_t size = 0; size < bytes.size(); ++size) {
    const auto cut = DecodeBlob(std::span(bytes).first(size));
    ASSERT_FALSE(cut.ok()) << size;
    EXPECT_EQ(cut.status().code(), absl::StatusCode::kInvalidArgument);
  }
  bytes.push_back(std::byte{0});
  EXPECT_EQ(ErrorReason(DecodeBlob(bytes).status()), "LENGTH");
}

// Counts that overflow 32 bits when multiplied, or promise gigabytes: refused before anything is
// allocated.
TEST(Blob, A07ChecksDeclaredSizesFirst) {
  auto bytes = EncodeBlob(testing::UnitSquareGeometry());
  for (const uint32_t count : {0xffffffffu, 0x40000000u, 0x15555556u}) {
    for (const size_t offset : {8, 12}) {
      auto lying = bytes;
      std::memcpy(lying.data() + offset, &count, sizeof(count));
      EXPECT_EQ(ErrorReason(DecodeBlob(lying).status()), "LENGTH");
    }
  }
  auto mask = EncodeBlob(**AlphaMask::Create(1, 1, {255}));
  const uint32_t side = 65536;
  std::memcpy(mask.data() + 8, &side, 4);
  std::memcpy(mask.data() + 12, &side, 4);
  EXPECT_EQ(ErrorReason(DecodeBlob(mask).status()), "LENGTH");
}

TEST(Blob, A21RefusesOtherFormats) {
  auto bytes = EncodeBlob(testing::UnitSquareGeometry());
  bytes[0] = std::byte{'X'};
  EXPECT_THAT(std::string(DecodeBlob(bytes).status().message()),
              HasSubstr("need a mesh or a mask"));
  bytes = EncodeBlob(testing::UnitSquareGeometry());
  bytes[4] = std::byte{9};
  EXPECT_THAT(std::string(DecodeBlob(bytes).status().message()), HasSubstr("found version 9"));
  bytes = EncodeBlob(testing::UnitSquareGeometry());
  bytes[16] = std::byte{0x80};
  EXPECT_THAT(std::string(DecodeBlob(bytes).status().message()), HasSubstr("flags"));
}

TEST(AlphaMask, RepeatsAndTakesTheNearestTexel) {
  const auto mask = *AlphaMask::Create(2, 1, {0, 255});
  EXPECT_EQ(mask->At({0.25f, 0.5f}), 0.0f);
  EXPECT_EQ(mask->At({0.75f, 0.5f}), 1.0f);
  EXPECT_EQ(mask->At({-0.25f, 7.5f}), 1.0f);
  EXPECT_EQ(mask->At({1.25f, -3.0f}), 0.0f);
  EXPECT_EQ(ErrorReason(AlphaMask::Create(0, 1, {}).status()), "IMAGE_SIZE");
  EXPECT_EQ(ErrorReason(AlphaMask::Create(2, 2, {1, 2, 3}).status()), "LENGTH");
}

}  // namespace
}  // namespace penumbra
