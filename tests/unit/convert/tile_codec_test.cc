#include "proto/convert/tile_codec.h"

#include <gtest/gtest.h>
#include <zstd.h>

#include <functional>
#include <string>

#include "render/scene/field_error.h"
#include "tests/support/random_scene.h"

namespace penumbra {
namespace {

using testing::Dice;

ShadowTexels Texture(uint32_t width, uint32_t height, uint32_t samples, bool radiance) {
  ShadowTexels texture;
  texture.visibility = {.width = width,
                        .height = height,
                        .sample_count = samples,
                        .counts = std::vector<uint16_t>(size_t{width} * height)};
  if (radiance) {
    texture.radiance = RadianceTexture{
        .width = width, .height = height, .texels = std::vector<Vec3>(size_t{width} * height)};
  }
  return texture;
}

ShadowTexels RandomTexture(uint32_t width, uint32_t height, uint32_t samples, bool radiance) {
  Dice dice(width * 7919 + samples);
  ShadowTexels texture = Texture(width, height, samples, radiance);
  for (auto& count : texture.visibility.counts) {
    count = static_cast<uint16_t>(dice.Below(samples + 1));
  }
  if (radiance) {
    for (auto& texel : texture.radiance->texels) texel = dice.InCube(10);
  }
  return texture;
}

void ForTiles(const ShadowTexels& texture,
              const std::function<void(uint32_t column, uint32_t row)>& visit) {
  const TileGrid grid = GridOf(texture);
  for (uint32_t row = 0; row < grid.rows(); ++row) {
    for (uint32_t column = 0; column < grid.columns(); ++column) visit(column, row);
  }
}

void ExpectThereAndBack(const ShadowTexels& texture) {
  ShadowTexels back = Texture(texture.visibility.width, texture.visibility.height,
                              texture.visibility.sample_count, texture.radiance.has_value());
  TileEncoder encoder;
  TileDecoder decoder;
  ForTiles(texture, [&](uint32_t column, uint32_t row) {
    const auto status = decoder.Decode(encoder.Encode(texture, column, row), back);
    EXPECT_TRUE(status.ok()) << status;
    EXPECT_TRUE(TilesEqual(texture, back, column, row));
  });
  EXPECT_EQ(back.visibility.counts, texture.visibility.counts);
  if (texture.radiance) {
    EXPECT_EQ(back.radiance->texels, texture.radiance->texels);
  }
}

TEST(TileCodecTest, NoiseGoesThereAndBackForAnySize) {
  for (const uint32_t samples : {1u, 2u, 255u, 256u, 1024u, 65535u}) {
    for (const auto& [width, height] : {std::pair{1u, 1u}, {64u, 64u}, {65u, 63u}, {200u, 130u}}) {
      ExpectThereAndBack(RandomTexture(width, height, samples, false));
      ExpectThereAndBack(RandomTexture(width, height, samples, true));
    }
  }
}

TEST(TileCodecTest, RoundedRadianceGoesThereAndBackInFewerBytes) {
  for (const RadianceFormat format :
       {RadianceFormat::kHalf, RadianceFormat::kUnorm16, RadianceFormat::kUnorm8}) {
    for (const float scale : {0.7f, 9.0f}) {
      ShadowTexels texture = RandomTexture(70, 66, 300, true);
      RoundTo(format, scale, *texture.radiance);
      ShadowTexels back = Texture(70, 66, 300, true);
      back.radiance->format = format;
      back.radiance->scale = texture.radiance->scale;
      TileEncoder encoder;
      TileDecoder decoder;
      ForTiles(texture, [&](uint32_t column, uint32_t row) {
        const v1::Tile tile = encoder.Encode(texture, column, row);
        const size_t texels = (column == 0 ? 64 : 6) * (row == 0 ? 64 : 2);
        EXPECT_LE(tile.radiance().size(), texels * 3 * BytesPerChannel(format));
        EXPECT_TRUE(decoder.Decode(tile, back).ok());
      });
      EXPECT_EQ(back.radiance->texels, texture.radiance->texels);
      // A plane of another format has another length.
      back.radiance->format =
          format == RadianceFormat::kUnorm8 ? RadianceFormat::kHalf : RadianceFormat::kUnorm8;
      const auto status = decoder.Decode(encoder.Encode(texture, 0, 0), back);
      EXPECT_EQ(ErrorFieldPath(status), "tile.radiance");
    }
  }
}

TEST(TileCodecTest, CountsTakeTheBitsAskedFor) {
  ShadowTexels texture = RandomTexture(64, 64, 200, false);
  TileEncoder encoder;
  const auto size = [&](uint32_t bits) -> size_t {
    texture.count_bits = bits;
    const v1::Tile tile = encoder.Encode(texture, 0, 0);
    ShadowTexels back = Texture(64, 64, 200, false);
    back.count_bits = bits;
    TileDecoder decoder;
    EXPECT_TRUE(decoder.Decode(tile, back).ok());
    EXPECT_EQ(back.visibility.counts, texture.visibility.counts);
    if (tile.counts_codec() == v1::CODEC_RAW) return tile.counts().size();
    return static_cast<size_t>(
        ZSTD_getFrameContentSize(tile.counts().data(), tile.counts().size()));
  };
  EXPECT_EQ(size(16), 2u * 64 * 64);
  EXPECT_EQ(size(8), 64u * 64);
  EXPECT_EQ(size(0), 64u * 64);
}

TEST(TileCodecTest, FormatsAreTheSameOrNot) {
  ShadowTexels a = Texture(4, 4, 2, true), b = a;
  EXPECT_TRUE(HaveSameRadianceFormat(a, b));
  b.radiance->format = RadianceFormat::kHalf;
  EXPECT_FALSE(HaveSameRadianceFormat(a, b));
  b = a;
  b.radiance->scale = 2;
  EXPECT_FALSE(HaveSameRadianceFormat(a, b));
  b.radiance.reset();
  EXPECT_FALSE(HaveSameRadianceFormat(a, b));
}

TEST(TileCodecTest, FlatTilesCarryNoBytes) {
  ShadowTexels texture = Texture(64, 64, 300, false);
  TileEncoder encoder;
  EXPECT_EQ(encoder.Encode(texture, 0, 0).counts_codec(), v1::CODEC_NONE_VISIBLE);
  EXPECT_TRUE(encoder.Encode(texture, 0, 0).counts().empty());
  ExpectThereAndBack(texture);
  texture.visibility.counts.assign(64 * 64, 300);
  EXPECT_EQ(encoder.Encode(texture, 0, 0).counts_codec(), v1::CODEC_ALL_VISIBLE);
  ExpectThereAndBack(texture);
  texture.visibility.counts.back() = 299;
  EXPECT_EQ(encoder.Encode(texture, 0, 0).counts_codec(), v1::CODEC_ZSTD);
  ExpectThereAndBack(texture);
}

TEST(TileCodecTest, NoiseIsNotMadeLonger) {
  const auto tile = TileEncoder().Encode(RandomTexture(64, 64, 65535, false), 0, 0);
  EXPECT_EQ(tile.counts_codec(), v1::CODEC_RAW);
  EXPECT_EQ(tile.counts().size(), 64u * 64 * 2);
}

TEST(TileCodecTest, FlatTilesAreEqualAcrossSampleCounts) {
  ShadowTexels coarse = Texture(128, 64, 8, false);
  ShadowTexels fine = Texture(128, 64, 64, false);
  for (uint32_t i = 0; i < 64; ++i) {  // the left tile is lit, the right one half lit
    for (uint32_t j = 0; j < 64; ++j) {
      coarse.visibility.counts[j * 128 + i] = 8;
      fine.visibility.counts[j * 128 + i] = 64;
      coarse.visibility.counts[j * 128 + 64 + i] = i < 32 ? 8 : 0;
      fine.visibility.counts[j * 128 + 64 + i] = i < 32 ? 64 : 0;
    }
  }
  EXPECT_TRUE(TilesEqual(coarse, fine, 0, 0));
  EXPECT_FALSE(TilesEqual(coarse, fine, 1, 0));
  CopyTiles(coarse, fine);
  EXPECT_EQ(fine.visibility.At(5, 5), 64);
}

TEST(TileCodecTest, ADifferenceOfOneTexelIsSeen) {
  const ShadowTexels a = RandomTexture(130, 70, 64, true);
  ShadowTexels b = a;
  b.visibility.counts.back() ^= 1;
  EXPECT_FALSE(TilesEqual(a, b, 2, 1));
  EXPECT_TRUE(TilesEqual(a, b, 1, 1));
  b = a;
  b.radiance.value().texels[64].y += 1;
  EXPECT_FALSE(TilesEqual(a, b, 1, 0));
  EXPECT_TRUE(TilesEqual(a, b, 0, 0));
}

struct BadTile {
  const char* reason;
  const char* field;
  std::function<void(v1::Tile&)> spoil;
};

std::string ZstdOf(const std::string& plain) {
  std::string packed(ZSTD_compressBound(plain.size()), '\0');
  packed.resize(ZSTD_compress(packed.data(), packed.size(), plain.data(), plain.size(), 1));
  return packed;
}

const BadTile kBadTiles[] = {
    {"RANGE", "tile", [](v1::Tile& tile) { tile.set_column(2); }},
    {"RANGE", "tile", [](v1::Tile& tile) { tile.set_row(0xffffffffu); }},
    {"CODEC", "tile.counts", [](v1::Tile& tile) { tile.clear_counts_codec(); }},
    {"CODEC", "tile.counts", [](v1::Tile& tile) { tile.set_counts_codec(v1::Codec(77)); }},
    {"CODEC", "tile.counts",
     [](v1::Tile& tile) {
       tile.set_counts_codec(v1::CODEC_ZSTD);
       tile.set_counts("no frame");
     }},
    {"CODEC", "tile.counts",
     [](v1::Tile& tile) {  // 64 MB in a few KB
       tile.set_counts_codec(v1::CODEC_ZSTD);
       tile.set_counts(ZstdOf(std::string(64 << 20, '\0')));
     }},
    {"LENGTH", "tile.counts",
     [](v1::Tile& tile) {
       tile.set_counts_codec(v1::CODEC_ZSTD);
       tile.set_counts(ZstdOf(std::string(100, '\0')));
     }},
    {"LENGTH", "tile.counts",
     [](v1::Tile& tile) {
       tile.set_counts_codec(v1::CODEC_RAW);
       tile.set_counts(std::string(64 * 64 - 1, '\0'));
     }},
    {"RANGE", "tile.counts",
     [](v1::Tile& tile) {
       tile.set_counts_codec(v1::CODEC_RAW);
       tile.set_counts(std::string(64 * 64, '\x11'));  // 17 of 16
     }},
    {"CODEC", "tile.radiance", [](v1::Tile& tile) { tile.set_radiance_codec(v1::Codec(0)); }},
    {"LENGTH", "tile.radiance",
     [](v1::Tile& tile) {
       tile.set_radiance_codec(v1::CODEC_RAW);
       tile.set_radiance("short");
     }},
};

TEST(TileCodecTest, BadTilesAreErrors) {
  const ShadowTexels texture = RandomTexture(128, 64, 16, true);
  for (const BadTile& bad : kBadTiles) {
    v1::Tile tile = TileEncoder().Encode(texture, 0, 0);
    bad.spoil(tile);
    ShadowTexels into = Texture(128, 64, 16, true);
    const auto status = TileDecoder().Decode(tile, into);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_EQ(ErrorReason(status), bad.reason) << status;
    EXPECT_EQ(ErrorFieldPath(status), bad.field) << status;
  }
}

}  // namespace
}  // namespace penumbra
